// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/board/fit.h"
#include "alidade/calibrate/uncertainty/uncertainty.h"
#include "alidade/camera/any_camera.h"
#include "alidade/target/view.h"

namespace alidade {

/// The radius about the mean that a normal variable in the plane does not exceed with a probability of 95 %.
[[nodiscard]] double radius95(const Eigen::Matrix2d& covariance);

/// For each pixel, true if it is within the convex hull of some view's corners.
[[nodiscard]] std::vector<bool> isCovered(std::span<const Eigen::Vector2d> pixels,
                                          std::span<const View> views);

/// Those of the pixels that are covered.
[[nodiscard]] std::vector<Eigen::Vector2d> coveredPixels(std::span<const Eigen::Vector2d> pixels,
                                                         const std::vector<bool>& is_covered);

/// The same lens in a more flexible model of the same kind (see ModelTraits::flexible_id), with nothing held
/// and nothing solved again. Nothing if there is no such model.
/// @param fit  of one camera
[[nodiscard]] std::optional<Fit> flexibleFit(const Fit& fit);

/// @param fit    of one camera, solved
/// @param known  with a covariance and the image bias
/// @param alternatives  cameras that explain the corners equally well
/// @param distance_m  of the points, positive; may be infinite
[[nodiscard]] Accuracy accuracyOf(const Fit& fit, const Uncertainty& known,
                                  std::span<const AnyCamera> alternatives,
                                  double distance_m = std::numeric_limits<double>::infinity());

}  // namespace alidade
