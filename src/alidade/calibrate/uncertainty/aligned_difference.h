// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"

namespace alidade {

/// Displacement between the pixels of cameras a and b for the points that a sees at `distance_m`, px; NaN if
/// one of the two does not see a point. The frames are aligned by the best fit to the rays of `anchors`,
/// pixels at which both cameras are known to be right, so that no difference elsewhere affects the alignment.
/// It is a rotation at an infinite distance, otherwise a pose, and the result is then the same for all
/// distances.
[[nodiscard]] std::vector<double> alignedDifferences(
    const AnyCamera& a, const AnyCamera& b, std::span<const Eigen::Vector2d> pixels,
    std::span<const Eigen::Vector2d> anchors, double distance_m = std::numeric_limits<double>::infinity());

/// The largest of these differences, with the pixels as their own anchors; NaN if there is none.
[[nodiscard]] double largestDifference(const AnyCamera& a, const AnyCamera& b,
                                       std::span<const Eigen::Vector2d> pixels,
                                       double distance_m = std::numeric_limits<double>::infinity());

}  // namespace alidade
