// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <type_traits>

#include "alidade/geometry/stumpff.h"

namespace alidade {

namespace detail {
/// @throws Error if the quaternion [x, y, z, w] cannot be normalised.
void requireDirection(const std::array<double, 4>& xyzw);
}  // namespace detail

/// The 3x3 matrix of the cross product: hat(a) * b = a x b. `a` is a 3-vector.
template <class Derived>
[[nodiscard]] Eigen::Matrix<typename Derived::Scalar, 3, 3> hat(const Eigen::MatrixBase<Derived>& a) {
  EIGEN_STATIC_ASSERT_VECTOR_SPECIFIC_SIZE(Derived, 3);
  using T = typename Derived::Scalar;
  const Eigen::Matrix<T, 3, 1> v = a;
  Eigen::Matrix<T, 3, 3> m;
  m << T(0.0), -v.z(), v.y(),  //
      v.z(), T(0.0), -v.x(),   //
      -v.y(), v.x(), T(0.0);
  return m;
}

/// A rotation of 3-space: `a_from_b` takes the coordinates of a vector in frame b to those in frame a,
/// p_a = a_from_b * p_b.
///
/// Stored as a unit quaternion, up to rounding; q and -q are the same rotation. The tangent is the rotation
/// vector, axis times angle in radians, as a right perturbation R * exp(d). T is double or an automatic
/// differentiation type; derivatives are also correct at the identity. NaN inputs give NaN results. Formulas:
/// Sola, Deray and Atchuthan 2018 (arXiv 1812.01537), appendix B.
template <class T>
class BasicSO3 {
 public:
  using Scalar = T;
  using Vec3 = Eigen::Matrix<T, 3, 1>;
  using Mat3 = Eigen::Matrix<T, 3, 3>;
  /// Not aligned: Eigen's alignment of four doubles depends on compiler flags, and the layout of a rotation
  /// must not.
  using Quaternion = Eigen::Quaternion<T, Eigen::DontAlign>;
  using Tangent = Vec3;
  static constexpr int kDim = 3;

  /// The identity.
  BasicSO3() : q_(Quaternion::Identity()) {}

  /// Normalises `q`, which may have any length.
  /// @throws Error if T is a floating-point type and `q` has no direction: zero (or so near that its squared
  /// norm underflows), NaN or infinite. For other types the result is then NaN.
  [[nodiscard]] static BasicSO3 fromQuaternion(const Quaternion& q) {
    if constexpr (std::is_floating_point_v<T>) {
      detail::requireDirection({q.x(), q.y(), q.z(), q.w()});
    }
    return BasicSO3(normalised(q));
  }

  /// The rotation by |w| radians about w, for any finite w.
  [[nodiscard]] static BasicSO3 exp(const Vec3& w) {
    const auto c = detail::stumpff(T(T(0.25) * w.squaredNorm()));
    const Vec3 v = T(0.5) * c[1] * w;
    return BasicSO3(Quaternion(c[0], v.x(), v.y(), v.z()));
  }

  /// The rotation vector, of length in [0, pi]. At exactly pi (a quaternion with real part 0), both signs are
  /// the same rotation; the result is the one whose first non-zero component is positive. The derivative
  /// exists below pi.
  [[nodiscard]] Vec3 log() const {
    using std::atan2;
    using std::sqrt;
    const bool flip = usesOppositeQuaternion();
    const T w = flip ? T(-q_.w()) : q_.w();
    const T sine2 = q_.vec().squaredNorm();  // of half the angle
    T half_angle_by_sine;
    if (sine2 < T(kLogSeriesLimit) * w * w) {
      const T tan2 = sine2 / (w * w);
      // arctan(t) / t in powers of t^2, because the root of sine2 has no derivative at zero.
      const T series = T(1.0 / 5.0) - tan2 * (T(1.0 / 7.0) - tan2 * T(1.0 / 9.0));
      half_angle_by_sine = (T(1.0) - tan2 * (T(1.0 / 3.0) - tan2 * series)) / w;
    } else {
      const T sine = sqrt(sine2);
      half_angle_by_sine = atan2(sine, w) / sine;
    }
    return (flip ? T(-2.0) : T(2.0)) * half_angle_by_sine * q_.vec();
  }

  [[nodiscard]] Mat3 matrix() const { return q_.toRotationMatrix(); }
  /// The unit quaternion, with either sign.
  [[nodiscard]] const Quaternion& quaternion() const { return q_; }
  [[nodiscard]] BasicSO3 inverse() const { return BasicSO3(q_.conjugate()); }

  /// a_from_c = a_from_b * b_from_c. Normalised each time, so that a long product remains a rotation.
  [[nodiscard]] BasicSO3 operator*(const BasicSO3& other) const {
    return BasicSO3(normalised(q_ * other.q_));
  }
  /// p_a = a_from_b * p_b.
  [[nodiscard]] Vec3 operator*(const Vec3& p) const { return q_._transformVector(p); }

  /// R exp(d) R^-1 = exp(adjoint() d): 3x3, equal to matrix().
  [[nodiscard]] Mat3 adjoint() const { return matrix(); }

  /// The same rotation with another scalar type, such as a constant among automatic derivatives.
  template <class U>
  [[nodiscard]] BasicSO3<U> cast() const {
    return BasicSO3<U>(q_.template cast<U>());
  }

  /// 3x3, exp(w + d) = exp(leftJacobian(w) d) exp(w) to first order in d (Sola et al., eq. 145).
  [[nodiscard]] static Mat3 leftJacobian(const Vec3& w) {
    const auto c = detail::stumpff(T(w.squaredNorm()));
    const Mat3 W = hat(w);
    return Mat3::Identity() + c[2] * W + c[3] * (W * W);
  }
  /// 3x3, exp(w + d) = exp(w) exp(rightJacobian(w) d) to first order in d (Sola et al., eq. 143).
  [[nodiscard]] static Mat3 rightJacobian(const Vec3& w) { return leftJacobian(-w); }

  /// 3x3, log(exp(d) exp(w)) = w + leftJacobianInverse(w) d to first order in d, with w = log() of a rotation
  /// (Sola et al., eq. 146). For |w| < 2 pi; at 2 pi the Jacobian is singular and its inverse unbounded.
  [[nodiscard]] static Mat3 leftJacobianInverse(const Vec3& w) {
    // 1/angle^2 - (1 + cos(angle)) / (2 angle sin(angle)) in terms of half the angle: no 0/0 at 0 nor at pi.
    const auto c = detail::stumpff(T(T(0.25) * w.squaredNorm()));
    const T coefficient = (c[2] - c[3]) / (T(4.0) * c[1]);
    const Mat3 W = hat(w);
    return Mat3::Identity() - T(0.5) * W + coefficient * (W * W);
  }
  /// 3x3, log(exp(w) exp(d)) = w + rightJacobianInverse(w) d to first order in d (Sola et al., eq. 144). Same
  /// domain as leftJacobianInverse().
  [[nodiscard]] static Mat3 rightJacobianInverse(const Vec3& w) { return leftJacobianInverse(-w); }

 private:
  template <class U>
  friend class BasicSO3;

  /// On tan(angle / 2)^2; the first term left out of the series is then 1e-21.
  static constexpr double kLogSeriesLimit = 1e-4;

  explicit BasicSO3(const Quaternion& unit) : q_(unit) {}

  /// NaN for a zero `q`: Eigen's normalized() would return zero, whose matrix is the identity.
  static Quaternion normalised(const Quaternion& q) {
    using std::sqrt;
    return Quaternion(q.coeffs() / T(sqrt(q.squaredNorm())));
  }

  /// True if -q_ is the one of the two quaternions whose angle is in [0, pi].
  [[nodiscard]] bool usesOppositeQuaternion() const {
    const T zero(0.0);
    if (q_.w() != zero) return q_.w() < zero;
    for (const T& component : {q_.x(), q_.y(), q_.z()}) {
      if (component != zero) return component < zero;
    }
    return false;
  }

  Quaternion q_;
};

using SO3 = BasicSO3<double>;

}  // namespace alidade
