// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "alidade/geometry/so3.h"
#include "alidade/geometry/stumpff.h"

namespace alidade {

/// A rigid motion: `a_from_b` takes the coordinates of a point in frame b to those in frame a,
/// p_a = a_from_b * p_b = rotation * p_b + translation. Metres.
///
/// The tangent is xi = [translation(3), rotation(3)], metres and radians, as a right perturbation X *
/// exp(xi). T is double or an automatic differentiation type. Formulas: Sola, Deray and Atchuthan 2018 (arXiv
/// 1812.01537), appendix D.
template <class T>
struct BasicSE3 {
  using Scalar = T;
  using Rotation = BasicSO3<T>;
  using Vec3 = Eigen::Matrix<T, 3, 1>;
  using Mat3 = Eigen::Matrix<T, 3, 3>;
  using Mat4 = Eigen::Matrix<T, 4, 4>;
  using Vec6 = Eigen::Matrix<T, 6, 1>;
  using Mat6 = Eigen::Matrix<T, 6, 6>;
  using Tangent = Vec6;
  static constexpr int kDim = 6;

  Rotation rotation;                ///< a_from_b
  Vec3 translation = Vec3::Zero();  ///< the origin of frame b, in frame a

  /// The motion at time 1 along the constant twist xi, for any finite xi (Sola et al., eq. 172).
  [[nodiscard]] static BasicSE3 exp(const Vec6& xi) {
    const Vec3 w = xi.template tail<3>();
    return {Rotation::exp(w), Rotation::leftJacobian(w) * xi.template head<3>()};
  }

  /// The twist with a rotation of length in [0, pi] (Sola et al., eq. 173). At exactly pi, see
  /// BasicSO3::log().
  [[nodiscard]] Vec6 log() const {
    const Vec3 w = rotation.log();
    Vec6 xi;
    xi << Rotation::leftJacobianInverse(w) * translation, w;
    return xi;
  }

  /// b_from_a.
  [[nodiscard]] BasicSE3 inverse() const {
    const Rotation b_from_a = rotation.inverse();
    return {b_from_a, -(b_from_a * translation)};
  }

  /// a_from_c = a_from_b * b_from_c.
  [[nodiscard]] BasicSE3 operator*(const BasicSE3& other) const {
    return {rotation * other.rotation, rotation * other.translation + translation};
  }
  /// p_a = a_from_b * p_b.
  [[nodiscard]] Vec3 operator*(const Vec3& p) const { return rotation * p + translation; }

  /// 4x4 homogeneous: [rotation, translation; 0 0 0 1].
  [[nodiscard]] Mat4 matrix() const {
    Mat4 m = Mat4::Identity();
    m.template topLeftCorner<3, 3>() = rotation.matrix();
    m.template topRightCorner<3, 1>() = translation;
    return m;
  }

  /// 6x6, X exp(d) X^-1 = exp(adjoint() d) (Sola et al., eq. 175).
  [[nodiscard]] Mat6 adjoint() const {
    const Mat3 R = rotation.matrix();
    return blockTriangular(R, hat(translation) * R);
  }

  /// The same motion with another scalar type.
  template <class U>
  [[nodiscard]] BasicSE3<U> cast() const {
    return {rotation.template cast<U>(), translation.template cast<U>()};
  }

  /// 6x6, exp(xi + d) = exp(leftJacobian(xi) d) exp(xi) to first order in d (Sola et al., eq. 179a).
  [[nodiscard]] static Mat6 leftJacobian(const Vec6& xi) {
    return blockTriangular(Rotation::leftJacobian(xi.template tail<3>()), couplingBlock(xi));
  }
  /// 6x6, exp(xi + d) = exp(xi) exp(rightJacobian(xi) d) to first order in d.
  [[nodiscard]] static Mat6 rightJacobian(const Vec6& xi) { return leftJacobian(-xi); }

  /// 6x6, log(exp(d) exp(xi)) = xi + leftJacobianInverse(xi) d to first order in d (Sola et al., eq. 179b).
  /// For a rotation of less than 2 pi; near 2 pi it grows without bound.
  [[nodiscard]] static Mat6 leftJacobianInverse(const Vec6& xi) {
    const Mat3 J_inverse = Rotation::leftJacobianInverse(xi.template tail<3>());
    return blockTriangular(J_inverse, -J_inverse * couplingBlock(xi) * J_inverse);
  }
  /// 6x6, log(exp(xi) exp(d)) = xi + rightJacobianInverse(xi) d to first order in d. Same domain as
  /// leftJacobianInverse().
  [[nodiscard]] static Mat6 rightJacobianInverse(const Vec6& xi) { return leftJacobianInverse(-xi); }

 private:
  /// [diagonal, upper; 0, diagonal].
  static Mat6 blockTriangular(const Mat3& diagonal, const Mat3& upper) {
    Mat6 m;
    m << diagonal, upper, Mat3::Zero(), diagonal;
    return m;
  }

  /// The 3x3 block of the left Jacobian by which a change of rotation moves the translation: Q of Barfoot and
  /// Furgale 2014, eq. 102. Their coefficients with angle^4 and angle^5 below are c_4 and (c_4 - 3 c_5) / 2.
  static Mat3 couplingBlock(const Vec6& xi) {
    const Mat3 V = hat(xi.template head<3>());
    const Mat3 W = hat(xi.template tail<3>());
    const auto c = detail::stumpff(T(xi.template tail<3>().squaredNorm()));
    const Mat3 WV = W * V;
    const Mat3 VW = V * W;
    const Mat3 WVW = WV * W;
    return T(0.5) * V + c[3] * (WV + VW + WVW) + c[4] * (W * WV + VW * W - T(3.0) * WVW) +
           T(0.5) * (c[4] - T(3.0) * c[5]) * (WVW * W + W * WVW);
  }
};

using SE3 = BasicSE3<double>;

}  // namespace alidade
