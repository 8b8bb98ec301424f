// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "alidade/target/view.h"

namespace alidade {

/// For each pixel, true if it is within the convex hull of some view's corners.
[[nodiscard]] std::vector<bool> isCovered(std::span<const Eigen::Vector2d> pixels,
                                          std::span<const View> views);

/// The pixels within the convex hull of some view's corners.
[[nodiscard]] std::vector<Eigen::Vector2d> coveredPixels(std::span<const Eigen::Vector2d> pixels,
                                                         std::span<const View> views);

}  // namespace alidade
