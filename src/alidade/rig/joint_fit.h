// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/board/fit.h"
#include "alidade/core/cancel.h"
#include "alidade/rig/joint_views.h"
#include "alidade/rig/rig_calibration.h"

namespace alidade {

/// The boards that are uneven in any of these fits; all fits have the same boards.
[[nodiscard]] std::vector<std::size_t> unevenBoards(std::span<const Fit* const> fits);

/// The fit of all cameras, solved. View v of it is view v of the JointViews.
struct JointFit {
  Fit fit;
  std::vector<std::size_t> unlinked = {};  ///< views that contradict their frame, ascending
  /// Pose of the body from each view alone, with cameras and boards at their places in the fit.
  std::vector<SE3> rig_from_body = {};
  /// If images of a frame were not taken at one instant: the views have deviations.
  std::optional<ExposureScatter> exposure = {};
  bool are_points_lost = false;  ///< no point positions of uneven boards fit all cameras
};

/// Solves all intrinsics, poses and board shapes together. Views whose errors exceed three times the noise
/// contradict the others of their frame and get their own placement. Views deviate along the board's motion
/// if fewer of them contradict then: they were not taken at one instant.
[[nodiscard]] JointFit jointFit(const JointViews& views, std::span<const std::size_t> uneven,
                                const CancelFlag* cancel);

/// sqrt(mean of dx^2 + dy^2) over the corners of a camera, px; NaN without one.
[[nodiscard]] double rmsOfCamera(const Fit& fit, std::size_t camera);

/// A step in the pose of one camera of a rig.
struct PoseStep {
  std::size_t camera = 0;
  std::size_t first_frame = 0;  ///< after the step, as FitPlacement::frame
  /// camera_from_rig after the step is the one before times Exp(tangent).
  Eigen::Matrix<double, 6, 1> tangent = Eigen::Matrix<double, 6, 1>::Zero();
  double normal = 0;  ///< standard normal variable that chance exceeds as often in one test
};

/// The likeliest step, by a score test for each camera and frame with all unknowns of the rig free (Rao 1948,
/// Large sample tests of statistical hypotheses). Frames are in ascending order. Nothing if no step is likely
/// or the frames do not determine the rig.
/// @param fit       solved, at its optimum
/// @param variance  of the coordinate of a corner of weight 1, px^2
[[nodiscard]] std::optional<PoseStep> likeliestPoseStep(const Fit& fit, double variance);

}  // namespace alidade
