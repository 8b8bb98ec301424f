// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/board/fit.h"
#include "alidade/core/cancel.h"
#include "alidade/geometry/se3.h"
#include "alidade/record/hand_eye_record.h"

namespace alidade {

/// A robot pose and the views that were taken there.
struct RobotFrame {
  SE3 base_from_gripper = {};                     ///< as stated
  std::vector<std::size_t> views = {};            ///< indices into Fit::views
  SE3::Tangent deviation = SE3::Tangent::Zero();  ///< the gripper was at base_from_gripper * exp(deviation)
  double sigmas = 0;  ///< of the deviation, over those that the noise explains; about 1
};

/// A fit of one camera whose boards a robot moves:
///
///   camera_from_board = mount_from_camera^-1 * motion * world_from_board
///
/// where motion is gripper_from_base for a camera on the hand, and base_from_gripper for one on the base.
struct RobotFit {
  Fit fit;
  CameraOn camera_on = CameraOn::kHand;
  SE3 mount_from_camera = {};
  std::vector<SE3> world_from_boards = {};  ///< one per board of the fit
  std::vector<RobotFrame> frames = {};
  RobotNoise noise = {};       ///< a start, then the estimate
  double corner_sigma_px = 0;  ///< of the coordinate of a corner of weight 1; the same
  /// Of the camera's parameters, the tangent of mount_from_camera, and those of the boards.
  Eigen::MatrixXd covariance = {};
  /// Number of the coordinates of the deviations, of translations and of rotations, that the corners
  /// determine.
  std::array<double, 2> noise_freedom = {};
  bool is_converged = false;

  [[nodiscard]] Eigen::Index numParams() const { return std::ssize(onlyCamera(fit).params); }
};

/// The motion of a frame, see RobotFit.
[[nodiscard]] SE3 motionOf(CameraOn on, const SE3& base_from_gripper);

/// Minimises the robust cost of the corners and that of the robot's deviations, each over their variances,
/// which are estimated by restricted maximum likelihood in turn with the rest (Harville 1977, Maximum
/// likelihood approaches to variance component estimation, Journal of the American Statistical Association
/// 72(358)). Time and memory are linear in the number of frames.
/// @param fit  with poses from which Gauss and Newton's method converges
/// @throws Cancelled
[[nodiscard]] RobotFit solved(RobotFit fit, const CancelFlag* cancel);

/// The covariance as solved() states it, with another noise of corners or robot, or the lens known.
struct RobotNoiseShares {
  double corners = 1, translation = 1, rotation = 1;  ///< factors on standard deviations
  bool is_lens_known = false;
};
[[nodiscard]] Eigen::MatrixXd covarianceWith(const RobotFit& fit, const RobotNoiseShares& shares);

/// The factor on the robot's lengths that would make them agree best with the board's, less 1; one step from
/// a solved fit.
struct RobotScale {
  double excess = 0;
  double std = 0;
};
[[nodiscard]] RobotScale robotScale(const RobotFit& fit);

}  // namespace alidade
