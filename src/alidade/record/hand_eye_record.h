// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "alidade/core/diagnosis.h"
#include "alidade/geometry/se3.h"

namespace alidade {

/// What carries the camera.
enum class CameraOn {
  kHand,  ///< the gripper; the board stands still
  kBase,  ///< what the robot stands on; the gripper carries the board
};
/// "hand" or "base".
[[nodiscard]] constexpr std::string_view cameraOnName(CameraOn on) {
  return on == CameraOn::kHand ? "hand" : "base";
}

/// What carries the camera, and what it looks at boards on: "gripper" and "base", or the other way round.
[[nodiscard]] constexpr std::string_view mountName(CameraOn on) {
  return on == CameraOn::kHand ? "gripper" : "base";
}
[[nodiscard]] constexpr std::string_view worldName(CameraOn on) {
  return on == CameraOn::kHand ? "base" : "gripper";
}

/// How exactly a robot reaches the poses that it states: standard deviations of each axis.
struct RobotNoise {
  double rotation_rad = 0;
  double translation_m = 0;
};

/// The content of a hand-eye file: where a camera is on, or beside, a robot.
struct HandEyeRecord {
  CameraOn camera_on = CameraOn::kHand;
  /// gripper_from_camera, or base_from_camera.
  SE3 mount_from_camera = {};
  /// Of the tangent [translation, rotation] of mount_from_camera (metres, radians), 6x6; zero if unknown.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  /// base_from_board, or gripper_from_board, of each board.
  std::vector<SE3> world_from_boards = {};
  std::vector<std::string> boards = {};  ///< their specifications
  RobotNoise robot_noise = {};
  std::string camera_name = {};
  int num_poses = 0;   ///< in use
  double error_m = 0;  ///< 95 %, of a point at the boards' distance
  double rms_px = 0;
  Verdict verdict = Verdict::kTrustworthy;
  std::vector<std::string> findings = {};
  std::string created_by = {};
  std::string date = {};
};

}  // namespace alidade
