// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string_view>

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

/// The quaternion x, y, z, w with w >= 0.
[[nodiscard]] Eigen::Vector4d quaternionXyzw(const SO3& rotation);

/// The axes of three turns. By default R = Rz(yaw) Ry(pitch) Rx(roll): about z, then the new y, then the new
/// x axis; equivalently, about the fixed x, then y, then z axis.
struct EulerOrder {
  std::array<int, 3> axes = {2, 1, 0};  ///< x is 0; neighbours differ
  bool is_fixed = false;  ///< the axes stay where they are; otherwise the second and third turn along
};

/// The order of letters such as "zyx" or "zxz"; nothing for others.
[[nodiscard]] std::optional<EulerOrder> eulerOrder(std::string_view letters, bool is_fixed = false);

/// The Euler angles of a rotation.
struct EulerDecomposition {
  /// In the order of the axes. The middle one is in [-pi/2, pi/2], or in [0, pi] if the outer axes are the
  /// same; the others are in [-pi, pi].
  Eigen::Vector3d angles_rad;
  bool gimbal_lock = false;  ///< the outer axes coincide: only the sum or difference of their angles counts
};

/// Any finite angles, in the order of the axes.
/// @throws Error if one is not finite.
[[nodiscard]] SO3 rotationFromEuler(const Eigen::Vector3d& angles_rad, const EulerOrder& order = {});

/// The inverse of rotationFromEuler(). Within 1e-8 rad of gimbal lock, where the sine or cosine of the middle
/// angle is 1 to the last bit, it reports that, with 0 as the last angle (the first one of fixed axes) and
/// the determined combination as the other. The rotation of the angles equals the given one to rounding, and
/// under gimbal lock to the distance of the middle angle from the pole.
[[nodiscard]] EulerDecomposition eulerFromRotation(const SO3& rotation, const EulerOrder& order = {});

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

/// The mean of poses, and how far they are from it.
struct PoseMean {
  SE3 mean;  ///< the rotation with the least sum of squared angles (Karcher mean), and the mean translation
  double rms_rad = 0.0;  ///< sqrt(mean of the squared angles to it)
  double max_rad = 0.0;  ///< from 90 degrees on, another rotation may be as good a mean
  double rms_m = 0.0;    ///< sqrt(mean of the squared distances from it)
};
/// @param poses  at least one
[[nodiscard]] PoseMean meanPose(std::span<const SE3> poses);

}  // namespace alidade
