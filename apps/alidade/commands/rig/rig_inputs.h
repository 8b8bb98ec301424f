// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "alidade/record/rig_record.h"
#include "alidade/rig/rig_frames.h"
#include "alidade/target/board.h"
#include "alidade/target/frame_table.h"
#include "board_views.h"

// The inputs of commands that read the images of several cameras.

namespace alidade {

/// The inputs and options of a command for a rig: an input for each camera.
struct RigInputs : BoardInputs {
  std::vector<std::string> names = {};  ///< of the cameras; empty: from the inputs
  std::string match = {};               ///< table of frames; empty: none

  /// All flags, and the inputs as arguments.
  void addOptions(Flags& flags);
  /// The flag --match.
  void addMatch(Flags& flags);
  /// All files that are read.
  [[nodiscard]] std::vector<std::string> sources() const;
  /// @throws Error (kUsage) for names that are missing, empty or not different, and for inputs or images that
  /// are those of two cameras
  [[nodiscard]] std::vector<std::string> cameraNames(const CommonOptions& common) const;
  /// Puts inputs whose names are those of the cameras in the order of these, and tells that it did. Other
  /// inputs stay in their order.
  /// @throws Error (kUsage) as cameraNames()
  void sortLike(const std::vector<std::string>& cameras, const CommonOptions& common);
};

/// For each name the place of the camera of this name; nothing if there is none for some name, or one for
/// two.
[[nodiscard]] std::optional<std::vector<std::size_t>> placesByName(const std::vector<std::string>& names,
                                                                   const std::vector<std::string>& cameras);

/// Tells that a rig file says of itself that it must not be used.
void tellIfRejected(const RigRecord& rig, const std::string& path, bool is_quiet);

/// The views of all cameras, and the boards that they show.
struct RigInputViews {
  std::vector<Board> boards;
  std::vector<RigViews> cameras;
  std::vector<GivenViews> given;  ///< what was given for each camera, without the views
  FrameTable frames;              ///< from --match; or empty
};

/// Reads corners files or finds the boards, and tells how many images of each camera show one. Reads the
/// table of frames, and tells which of its images no corners file has.
/// @throws Error (kInput) as readViews(), and for cameras of different boards; Cancelled
[[nodiscard]] RigInputViews readRigViews(const RigInputs& inputs, const std::vector<std::string>& names,
                                         const CommonOptions& common);

}  // namespace alidade
