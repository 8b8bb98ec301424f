// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/board/fit.h"
#include "alidade/calibrate/calibrator.h"
#include "alidade/core/diagnosis.h"
#include "alidade/geometry/se3.h"
#include "alidade/record/hand_eye_record.h"

namespace alidade {

struct HandEyeOptions {
  CalibratorOptions camera = {};  ///< of the camera's own calibration
  /// Nothing: found from the poses, which are then taken as base_from_gripper.
  std::optional<CameraOn> camera_on = {};
  /// Names of all images in order, also of those without a board, for poses that are matched by order.
  std::vector<std::string> images = {};
  double tolerance_m = 1e-3;  ///< the error of a point at the boards' distance (95 %) that the user accepts
};

/// A robot pose and the image that belongs to it.
struct HandEyeFrame {
  std::string image;
  SE3 base_from_gripper = {};  ///< as the robot states it, after mending of the table
  /// base_from_gripper * exp(deviation) is where the gripper was, by all that is known; [translation,
  /// rotation], metres and radians.
  SE3::Tangent deviation = SE3::Tangent::Zero();
  double rms_px = 0;        ///< of the corners
  double sigmas = 0;        ///< of the deviation, as the length of a vector of 6 normal numbers over sqrt(6)
  std::string reason = {};  ///< why it is left out; empty: in use
};

/// A pose of the robot from which one more image would help.
struct NextPose {
  SE3 base_from_gripper = {};
  double error_m = 0;  ///< HandEyeCalibration::error_m with it, as expected
};

/// A calibrated hand-eye transform, and what is known about it.
struct HandEyeCalibration {
  Calibration camera;  ///< by the images alone
  Fit fit;             ///< joint: of the same views, as far as their robot poses are in use
  CameraOn camera_on = CameraOn::kHand;
  SE3 mount_from_camera = {};               ///< gripper_from_camera, or base_from_camera
  std::vector<SE3> world_from_boards = {};  ///< base_from_board, or gripper_from_board, of each board
  /// Covariance of the tangents of mount_from_camera, then of each board [translation, rotation].
  Eigen::MatrixXd covariance = {};
  RobotNoise robot_noise = {};
  std::vector<HandEyeFrame> frames = {};  ///< in the order of the images
  double board_distance_m = 0;            ///< mean
  double error_m = 0;       ///< 95 %, of a point at the boards' distance on the axis, in the mount's frame
  double tool_error_m = 0;  ///< the same at the mount's origin, seen from the camera
  std::optional<NextPose> next_pose = {};  ///< see nextPose()
  std::vector<Diagnosis> diagnoses = {};   ///< failures first

  /// False if a failure was found before the fit: then there are only diagnoses.
  [[nodiscard]] bool isSolved() const { return covariance.size() > 0; }
  [[nodiscard]] Verdict verdict() const { return verdictOf(diagnoses); }
  [[nodiscard]] bool isUsable() const { return verdict() != Verdict::kNo; }
};

}  // namespace alidade
