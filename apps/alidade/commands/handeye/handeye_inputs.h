// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "alidade/handeye/hand_eye.h"
#include "board_views.h"
#include "flags.h"

namespace alidade {

/// What the commands about a camera on a robot read: images of boards, and the robot's poses.
struct HandEyeInputs {
  BoardInputs views = {};
  std::string poses = {};
  std::string form = {};
  std::string camera_on = {};
  std::string camera = {};  ///< file of a camera whose lens is kept; empty: calibrated
  std::string model = {};
  std::string tolerance = "1mm";

  /// All flags but those of the output. The positional argument is the command's own.
  void addOptions(Flags& flags);
  /// The files that are read, for checkOutputs().
  [[nodiscard]] std::vector<std::string> sources() const;
  /// Reads all, and calibrates.
  [[nodiscard]] HandEyeCalibration calibrate(const CommonOptions& common) const;
  /// @throws Error (kUsage) unless it is a length above 0
  [[nodiscard]] double toleranceM() const;
};

/// "1.25 mm", with two digits or three.
[[nodiscard]] std::string millimetres(double value_m);

extern const char* const kPosesHelp;

}  // namespace alidade
