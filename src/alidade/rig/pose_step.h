// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>

#include <Eigen/Core>

#include "alidade/adjust/board/fit.h"

namespace alidade {

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
