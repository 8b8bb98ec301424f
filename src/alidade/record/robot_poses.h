// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "alidade/geometry/se3.h"

namespace alidade {

/// A pose that a robot states for the moment at which an image was taken.
struct RobotPose {
  std::string image;  ///< its name, number or time, as in the table; may be empty
  SE3 base_from_gripper = {};
};

/// A way to read the numbers of a table of robot poses.
struct RobotReading {
  std::string how;  ///< "the quaternion as w, x, y, z"; empty for the stated one
  std::vector<RobotPose> poses;
};

/// The poses of a table as it states them, and other readings of the same numbers that a mistake would make
/// the true ones.
struct RobotTable {
  std::vector<RobotPose> poses;
  std::vector<RobotReading> others = {};
};

}  // namespace alidade
