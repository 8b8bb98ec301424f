// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "alidade/geometry/so3.h"

namespace alidade {

/// How far, as a fraction of its own size, a derivative may be from one of a rotation. Wide enough for
/// central differences of a sampled motion, narrow enough to catch a transposed or mismatched pair.
inline constexpr double kAngularVelocityTolerance = 1e-6;

/// The angular velocity of frame `body` in frame `fixed`, in coordinates of `fixed`, radians per unit of
/// time: vee(dR/dt R^T), from R = fixed_from_body and its 3x3 derivative. A vector held in the body then
/// moves at omega x p_fixed.
///
/// The symmetric part of dR/dt R^T is zero for the derivative of a rotation.
/// @throws Error if its Frobenius norm exceeds `tolerance` times that of dR/dt, or is NaN.
[[nodiscard]] Eigen::Vector3d angularVelocity(const SO3& fixed_from_body, const Eigen::Matrix3d& derivative,
                                              double tolerance = kAngularVelocityTolerance);

/// The same angular velocity in coordinates of `body`: vee(R^T dR/dt) (what a gyroscope fixed to it reads).
[[nodiscard]] Eigen::Vector3d bodyAngularVelocity(const SO3& fixed_from_body,
                                                  const Eigen::Matrix3d& derivative,
                                                  double tolerance = kAngularVelocityTolerance);

}  // namespace alidade
