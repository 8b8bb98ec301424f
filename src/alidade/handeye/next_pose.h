// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "alidade/handeye/hand_eye_calibration.h"
#include "alidade/handeye/joint_fit.h"

namespace alidade {

/// The pose near those driven from which an image would lower the error of a point at the boards' distance
/// most: the camera turns by 30 degrees about the middle of the board, or moves a third nearer or farther.
/// Nothing if there are so many poses that one more changes little, or if none keeps the board in view.
/// @param fit  solved
[[nodiscard]] std::optional<NextPose> nextPose(const RobotFit& fit, const HandEyeCalibration& result);

/// The error (95 %) of a point given in the camera frame, seen in the mount's frame, metres: that of a sum of
/// squares with the same mean and variance as its own (Satterthwaite 1946; the quantile by Wilson and
/// Hilferty 1931).
/// @param covariance  of the tangent of mount_from_camera
[[nodiscard]] double errorAt(const Eigen::Matrix<double, 6, 6>& covariance, const Eigen::Vector3d& point);

}  // namespace alidade
