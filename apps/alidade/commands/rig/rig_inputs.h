// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "alidade/record/rig_record.h"
#include "alidade/rig/rig_calibration.h"
#include "alidade/rig/rig_frames.h"
#include "alidade/target/board.h"
#include "alidade/target/frame_table.h"
#include "board_views.h"

// Inputs of commands that read the images of several cameras.

namespace alidade {

/// The inputs and options of a command for a rig: one input per camera.
struct RigInputs : BoardInputs {
  std::vector<std::string> names = {};  ///< of the cameras; empty: derived from the inputs
  std::vector<std::string> mirrored_of =
      {};                  ///< --mirrored: one value, or one for each camera ("-": neither)
  std::string match = {};  ///< table of frames; empty: none
  /// The frame of each video that was taken together with the first one of the recording that started last;
  /// empty: all start together.
  std::vector<double> leads = {};

  /// All flags, and the inputs as arguments.
  void addOptions(Flags& flags);
  /// The flag --match.
  void addMatch(Flags& flags);
  /// Frames per second that all videos state; 0 if one states none, or for other inputs.
  /// @throws Error (kInput) if they differ, unless --match says which frames belong together
  [[nodiscard]] double rateOfVideos(const CommonOptions& common) const;
  /// Sets the leads of videos that start at different times, and prints a note. False if their frames that
  /// were taken together are those that the rig was calibrated from.
  bool shiftTo(const RigCalibration& rig, const CommonOptions& common);
  /// The value of --mirrored for a camera.
  [[nodiscard]] std::string mirroredOf(std::size_t camera) const;
  /// All files to be read.
  [[nodiscard]] std::vector<std::string> sources() const;
  /// @throws Error (kUsage) for names that are missing, empty or not unique, and for inputs or images that
  /// occur for two cameras
  [[nodiscard]] std::vector<std::string> cameraNames(const CommonOptions& common) const;
  /// Sorts inputs named after cameras into the cameras' order, and prints a note. Other inputs keep their
  /// order.
  /// @throws Error (kUsage) as cameraNames()
  void sortLike(const std::vector<std::string>& cameras, const CommonOptions& common);
  /// Moves the input of each camera, and its value of --mirrored, to a new place.
  void placeAt(const std::vector<std::size_t>& places);

 private:
  void requireMirroredCount() const;
};

/// The index of the camera with each name; nothing if a name has none, or two names have the same.
[[nodiscard]] std::optional<std::vector<std::size_t>> placesByName(const std::vector<std::string>& names,
                                                                   const std::vector<std::string>& cameras);

/// Prints a warning if a rig file states that it must not be used.
void tellIfRejected(const RigRecord& rig, const std::string& path, bool is_quiet);

/// The views of all cameras, and the boards in them.
struct RigInputViews {
  std::vector<Board> boards;
  std::vector<RigViews> cameras;
  std::vector<GivenViews> given;  ///< input of each camera, without the views
  FrameTable frames;              ///< from --match; may be empty
};

/// Reads corners files or finds the boards, and prints how many images of each camera show one. Reads the
/// table of frames, and prints which of its images are in no corners file.
/// @throws Error (kInput) as readViews(), and for cameras of different boards; Cancelled
[[nodiscard]] RigInputViews readRigViews(const RigInputs& inputs, const std::vector<std::string>& names,
                                         const CommonOptions& common);

}  // namespace alidade
