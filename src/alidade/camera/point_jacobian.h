// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"
#include "alidade/geometry/se3.h"

namespace alidade {

/// A pixel depends on the point (3), the pose by its tangent (6), and the camera's parameters.
[[nodiscard]] inline std::size_t numPixelInputs(const AnyCamera& camera) {
  return 9 + camera.parameters().size();
}

/// How the pixel of camera_from_points * point changes with all of these: row-major, 2 x numPixelInputs().
/// The tangent is that of SE3, [translation, rotation] applied on the right.
/// @returns false, and NaN everywhere, where the point has no pixel
bool pixelJacobian(const AnyCamera& camera, const SE3& camera_from_points, const Eigen::Vector3d& point,
                   std::span<double> J_px_inputs);

using RayJacobian = Eigen::Matrix<double, 3, 2, Eigen::RowMajor>;

/// How the unit ray of a pixel changes with the pixel; nothing where the lens folds at it. `ray` is what
/// AnyCamera::unproject() gives for it.
[[nodiscard]] std::optional<RayJacobian> rayJacobian(const AnyCamera& camera, const Eigen::Vector3d& ray);

}  // namespace alidade
