// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <span>

#include <Eigen/Core>

#include "alidade/adjust/board/fit.h"
#include "alidade/calibrate/uncertainty/uncertainty.h"
#include "alidade/camera/any_camera.h"

namespace alidade {

/// The radius about the mean that a normal variable in the plane does not exceed with a probability of 95 %.
[[nodiscard]] double radius95(const Eigen::Matrix2d& covariance);

/// @param fit    of one camera, solved
/// @param known  with a covariance and the image bias
/// @param alternatives  cameras that explain the corners equally well
/// @param distance_m  of the points, positive; may be infinite
[[nodiscard]] Accuracy accuracyOf(const Fit& fit, const Uncertainty& known,
                                  std::span<const AnyCamera> alternatives,
                                  double distance_m = std::numeric_limits<double>::infinity());

}  // namespace alidade
