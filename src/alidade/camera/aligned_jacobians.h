// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"
#include "alidade/camera/freed.h"

namespace alidade {

/// How the pixels of fixed scene points change with a camera's parameters, to first order, after alignment by
/// the rotation (or pose) that best undoes the change over all `pixels`: A(q) = J_params(q) - J_freed(q) W,
/// with J_freed W the least-squares fit, in pixels, of J_freed to J_params over those of the pixels that have
/// a ray.
struct AlignedJacobians {
  /// A(q)^T, N x 2 (pixels + others): two columns per pixel, px per unit; zero where a pixel has no ray.
  Eigen::MatrixXd transposed;
  std::vector<bool> has_ray;  ///< one per pixel, then one for each of the others
};

/// @param pixels  where the points are seen; the fit is over these
/// @param others  further pixels that do not take part in the fit
/// @param weights of the squared pixel changes in the fit, positive; empty: all equal
/// @param freed   nothing: no alignment, A = J_params
[[nodiscard]] AlignedJacobians alignedJacobians(const AnyCamera& camera,
                                                std::span<const Eigen::Vector2d> pixels,
                                                std::span<const Eigen::Vector2d> others,
                                                std::optional<Freed> freed,
                                                std::span<const double> weights = {});

}  // namespace alidade
