// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"

namespace alidade {

/// How far from each pixel of camera a camera b puts what a shows there at `distance_m`, px; NaN where one of
/// the two does not see it. The frames of the two are brought together by what fits the rays of `anchors`
/// best, pixels at which both cameras are known to be right: what they say elsewhere is then compared without
/// a share of the difference going into the alignment. It is a rotation at an infinite distance, otherwise a
/// pose, and the result is then the same for all distances.
[[nodiscard]] std::vector<double> alignedDifferences(
    const AnyCamera& a, const AnyCamera& b, std::span<const Eigen::Vector2d> pixels,
    std::span<const Eigen::Vector2d> anchors, double distance_m = std::numeric_limits<double>::infinity());

/// The largest of them, the pixels being their own anchors; NaN where the two have none in common.
[[nodiscard]] double largestDifference(const AnyCamera& a, const AnyCamera& b,
                                       std::span<const Eigen::Vector2d> pixels,
                                       double distance_m = std::numeric_limits<double>::infinity());

}  // namespace alidade
