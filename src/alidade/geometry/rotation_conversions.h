// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <optional>

#include "alidade/geometry/se3.h"
#include "alidade/geometry/so3.h"

namespace alidade {

/// How far R^T R may be from the identity, entry by entry, in a matrix that came from a file: six decimals.
inline constexpr double kRotationTolerance = 1e-6;

/// The rotation nearest to `R` in the Frobenius norm, U V^T of R = U S V^T (Schonemann 1966).
/// @throws Error naming the fault if an entry is not finite, an entry of R^T R is further than `tolerance`
/// (in (0, 1)) from the identity's, or R is a reflection (determinant -1).
[[nodiscard]] SO3 rotationFromMatrix(const Eigen::Matrix3d& R, double tolerance = kRotationTolerance);

/// The motion of a 4x4 homogeneous matrix [R t; 0 0 0 1]; SE3::matrix() is the way back.
/// @throws Error if the last row is further than `tolerance` from 0 0 0 1, t is not finite or R fails
/// rotationFromMatrix().
[[nodiscard]] SE3 motionFromMatrix(const Eigen::Matrix4d& matrix, double tolerance = kRotationTolerance);

/// R = Rz(yaw) Ry(pitch) Rx(roll): about the fixed x, then y, then z axis; or, which is the same, about z,
/// the turned y and the twice turned x axis.
struct EulerZyx {
  double yaw_rad = 0.0;
  double pitch_rad = 0.0;
  double roll_rad = 0.0;
};

/// Euler angles of a rotation, and whether they are the only ones.
struct EulerDecomposition {
  EulerZyx angles;           ///< pitch in [-pi/2, pi/2], yaw and roll in [-pi, pi]
  bool gimbal_lock = false;  ///< the rotation fixes only yaw - roll (pitch +pi/2) or yaw + roll (pitch -pi/2)
};

/// Any finite angles.
/// @throws Error if one is not finite.
[[nodiscard]] SO3 rotationFromEuler(const EulerZyx& angles);

/// The inverse of rotationFromEuler(). Within 1e-8 rad of pitch = +-pi/2, where sin(pitch) is 1 to the last
/// bit, it reports gimbal lock, puts roll at 0 and gives yaw the combination that is determined. Recomposing
/// gives the rotation back to rounding, and under gimbal lock to the 1e-8 rad by which the pitch is off the
/// pole.
[[nodiscard]] EulerDecomposition eulerFromRotation(const SO3& rotation);

/// The unit axis of the rotation matrix `R`, its eigenvector of eigenvalue 1: the null space of R - I. The
/// sign is that of the rotation vector, R = exp(angle * axis) with angle in (0, pi], and at pi as SO3::log().
/// Nothing for the identity (to rounding, 1e-15 rad), of which every axis is one. The direction is good to
/// about 1e-16 / angle, all that the entries of R can tell.
/// @throws Error if R fails rotationFromMatrix().
[[nodiscard]] std::optional<Eigen::Vector3d> rotationAxis(const Eigen::Matrix3d& R,
                                                          double tolerance = kRotationTolerance);

}  // namespace alidade
