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

/// What people do wrong with a robot. The first four are wrong readings of the numbers of a table.
enum class RobotMistake {
  kQuaternionOrder,  ///< x y z w, read as w x y z
  kMillimetres,      ///< read as metres
  kDegrees,          ///< of a rotation vector, read as radians
  kEulerOrder,       ///< turns about moving axes z, y, x, read as those about fixed ones
  kInverted,         ///< gripper_from_base is stated
  kLeftHanded,       ///< the z axes of both frames are mirrored
  kOtherRecording,   ///< the poses have nothing to do with the images
  kShifted,          ///< each image has the pose of the next one, the last that of the first
  kSwapped,          ///< two images have each other's poses
  kBoardMoved,       ///< by 10 cm and 5 degrees in its plane, before the second half of the views
  kOnePoseWrong,     ///< by 3 cm and 3 degrees
  kMirroredImages,   ///< in which a detector numbers each row in reverse
};

}  // namespace alidade
