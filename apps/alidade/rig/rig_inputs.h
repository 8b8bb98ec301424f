// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "alidade/core/cancel.h"
#include "alidade/rig/rig_frames.h"
#include "alidade/target/board.h"
#include "alidade/target/frame_table.h"
#include "options.h"

// The inputs of commands that read the images of several cameras.

namespace alidade {

/// What a command was told about the images of a rig.
struct RigInputs {
  std::vector<std::string> inputs;  ///< one for each camera
  std::vector<std::string> boards;  ///< SPECs
  std::vector<std::string> names;   ///< of the cameras; empty: from the inputs
  std::string match;                ///< table of frames; empty: none
  DetectionOptions detection;

  /// Flags for all but `inputs`.
  void addOptions(CLI::App& app);
  /// All files that are read.
  [[nodiscard]] std::vector<std::string> sources() const;
  /// @throws Error (kUsage) for names that are missing, empty or not different
  [[nodiscard]] std::vector<std::string> cameraNames(const std::string& command) const;
  [[nodiscard]] FrameTable frames() const;
};

/// The views of all cameras, and the boards that they show.
struct RigInputViews {
  std::vector<Board> boards;
  std::vector<RigViews> cameras;
};

/// Reads corners files or finds the boards, and tells how many images of each camera show one.
/// @throws Error (kInput) as readViews(), and for cameras of different boards; Cancelled
[[nodiscard]] RigInputViews readRigViews(const std::string& command, const RigInputs& inputs,
                                         const std::vector<std::string>& names, const CommonOptions& common,
                                         const CancelFlag* cancel);

}  // namespace alidade
