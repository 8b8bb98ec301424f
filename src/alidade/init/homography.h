// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>

namespace alidade {

/// The 3x3 homography with to ~ H from (homogeneous), by the normalised direct linear transform (Hartley and
/// Zisserman, 2nd ed., algorithm 4.2), scaled to unit Frobenius norm. Nothing for fewer than four points, or
/// where the points do not determine it (all on a line).
[[nodiscard]] std::optional<Eigen::Matrix3d> fitHomography(std::span<const Eigen::Vector2d> from,
                                                           std::span<const Eigen::Vector2d> to);

}  // namespace alidade
