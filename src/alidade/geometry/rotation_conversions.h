// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

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

/// The Euler angles of a rotation.
struct EulerDecomposition {
  EulerZyx angles;           ///< pitch in [-pi/2, pi/2], yaw and roll in [-pi, pi]
  bool gimbal_lock = false;  ///< only yaw - roll (pitch +pi/2) or yaw + roll (pitch -pi/2) is determined
};

/// Any finite angles.
/// @throws Error if one is not finite.
[[nodiscard]] SO3 rotationFromEuler(const EulerZyx& angles);

/// The inverse of rotationFromEuler(). Within 1e-8 rad of pitch = +-pi/2, where sin(pitch) is 1 to the last
/// bit, it reports gimbal lock, with a roll of 0 and the determined combination as yaw. The rotation of the
/// angles equals the given one to rounding, and under gimbal lock to the distance of the pitch from the pole.
[[nodiscard]] EulerDecomposition eulerFromRotation(const SO3& rotation);

/// The unit axis of the rotation matrix `R`: its eigenvector of eigenvalue 1, the null space of R - I. The
/// sign is that of the rotation vector, R = exp(angle * axis) with angle in (0, pi], and at pi that of
/// SO3::log(). Nothing for the identity (to rounding, 1e-15 rad), which has every axis. The direction is
/// accurate to about 1e-16 / angle, as the entries of R are.
/// @throws Error if R fails rotationFromMatrix().
[[nodiscard]] std::optional<Eigen::Vector3d> rotationAxis(const Eigen::Matrix3d& R,
                                                          double tolerance = kRotationTolerance);

/// The rotation that brings vectors a_i closest to vectors b_i in the weighted least-squares sense. Kabsch
/// 1976, A solution for the best rotation to relate two sets of vectors, Acta Crystallographica A32.
/// @param correlation  sum of w_i b_i a_i^T, finite
[[nodiscard]] SO3 bestRotation(const Eigen::Matrix3d& correlation);

}  // namespace alidade
