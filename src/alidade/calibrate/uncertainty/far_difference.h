// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"

namespace alidade {

/// How far from each pixel of camera a camera b puts what a shows there, infinitely far away, px; NaN where
/// one of the two does not see it. The frames of the two are brought together by the rotation that fits the
/// rays of `anchors` best, pixels at which both cameras are known to be right: what they say elsewhere is
/// then compared without a share of the difference going into the rotation.
[[nodiscard]] std::vector<double> farDifferences(const AnyCamera& a, const AnyCamera& b,
                                                 std::span<const Eigen::Vector2d> pixels,
                                                 std::span<const Eigen::Vector2d> anchors);

}  // namespace alidade
