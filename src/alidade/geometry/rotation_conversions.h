// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "alidade/geometry/se3.h"
#include "alidade/geometry/so3.h"

namespace alidade {

/// Largest difference of an entry of R^T R from the identity for a matrix from a file with six decimals.
inline constexpr double kRotationTolerance = 1e-6;

/// The rotation nearest to `R` in the Frobenius norm, U V^T of R = U S V^T (Schonemann 1966).
/// @throws Error naming the fault if an entry is not finite, an entry of R^T R differs from the identity by
/// more than `tolerance` (in (0, 1)), or R is a reflection (determinant -1).
[[nodiscard]] SO3 rotationFromMatrix(const Eigen::Matrix3d& R, double tolerance = kRotationTolerance);

/// The motion of a 4x4 homogeneous matrix [R t; 0 0 0 1]; the inverse of SE3::matrix().
/// @throws Error if the last row differs by more than `tolerance` from 0 0 0 1, t is not finite or R fails
/// rotationFromMatrix().
[[nodiscard]] SE3 motionFromMatrix(const Eigen::Matrix4d& matrix, double tolerance = kRotationTolerance);

/// R = Rz(yaw) Ry(pitch) Rx(roll): about the fixed x, then y, then z axis; equivalently, about z, then the
/// new y, then the new x axis.
struct EulerZyx {
  double yaw_rad = 0.0;
  double pitch_rad = 0.0;
  double roll_rad = 0.0;
};

/// Any finite angles.
/// @throws Error if one is not finite.
[[nodiscard]] SO3 rotationFromEuler(const EulerZyx& angles);

/// The rotation that brings vectors a_i closest to vectors b_i in the weighted least-squares sense. Kabsch
/// 1976, A solution for the best rotation to relate two sets of vectors, Acta Crystallographica A32.
/// @param correlation  sum of w_i b_i a_i^T, finite
[[nodiscard]] SO3 bestRotation(const Eigen::Matrix3d& correlation);

}  // namespace alidade
