// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <numbers>

#include "alidade/core/lanes.h"

namespace alidade {

/// Models that see behind the camera plane stop here. At 180 degrees all azimuths are the same ray, whose
/// image is a circle and not a pixel.
inline constexpr double kWideMaxAngle = std::numbers::pi - 1e-4;

namespace detail {

/// The series of atan(t) / t is used below this t^2, where its next term, t^6 / 7, is less than rounding. The
/// quotient itself would be 0 / 0 on the axis, and so would the derivatives of its square root.
inline constexpr double kSmallTangent2 = 1e-6;

/// theta / rho with theta = atan2(rho, z), a smooth function of rho2 = rho^2 and z. Not for rho2 = 0 with
/// z <= 0.
template <class T>
T angleOverRadius(const T& rho2, const T& z) {
  using std::atan2;
  using std::sqrt;
  if (z > 0.0 && rho2 < kSmallTangent2 * z * z) {
    const T t2 = rho2 / (z * z);
    return (1.0 + t2 * (-1.0 / 3.0 + t2 * 0.2)) / z;
  }
  const T rho = sqrt(rho2);
  return atan2(rho, z) / rho;
}

#if defined(ALIDADE_HAS_VECTORS)
/// Branch-free: the function hardly changes within 1e-12 rad of the axis, so a point at that angle stands for
/// closer ones. At kWideMaxAngle, the shift is below rounding too.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"  // see lanes.h
template <>
ALIDADE_ALWAYS_INLINE Lanes angleOverRadius(const Lanes& rho2, const Lanes& z) {
  constexpr double kTinyTangent2 = 1e-24;
  return lane::arcTangent2OverY(lane::squareRoot(Lanes(rho2 + kTinyTangent2 * z * z)), z);
}
#pragma GCC diagnostic pop
#endif

/// Derivative of angleOverRadius, of value q, by rho2. Its derivative by z is -1 / (rho2 + z^2).
template <class T>
ALIDADE_ALWAYS_INLINE T angleOverRadiusSlope(const T& rho2, const T& z, const T& q) {
  const T iz = 1.0 / z;
  const T near_axis = (-1.0 / 3.0 + 0.4 * rho2 * iz * iz) * iz * iz * iz;
  const T elsewhere = (z / (rho2 + z * z) - q) / (2.0 * rho2);
  return lane::select(lane::both(z > 0.0, rho2 < kSmallTangent2 * z * z), near_axis, elsewhere);
}

/// Jacobian (row-major 2x3) by the ray of m = (x, y) F(s, z), where s = scale (x^2 + y^2), from F and its
/// derivatives. All lenses without tangential terms have this form.
template <class K, class T>
ALIDADE_ALWAYS_INLINE void radialJacobian(const T* ray, const T& f, const T& df_ds, const T& df_dz,
                                          const K& scale, T* J_m_ray) {
  const T x = ray[0];
  const T y = ray[1];
  const T g = 2.0 * scale * df_ds;
  J_m_ray[0] = f + g * x * x;
  J_m_ray[1] = g * x * y;
  J_m_ray[2] = df_dz * x;
  J_m_ray[3] = J_m_ray[1];
  J_m_ray[4] = f + g * y * y;
  J_m_ray[5] = df_dz * y;
}

/// Scales (x, y, z) to unit length; a vector without a length becomes zero or NaN.
template <class T>
ALIDADE_ALWAYS_INLINE void makeUnitRay(const T& x, const T& y, const T& z, T* ray) {
  const T inverse = 1.0 / lane::squareRoot(T(x * x + y * y + z * z));
  ray[0] = x * inverse;
  ray[1] = y * inverse;
  ray[2] = z * inverse;
}

/// w d + (1 - w) z for d = sqrt(rho2 + z^2). Behind the camera, d and z nearly cancel; d + z = rho2 / (d - z)
/// keeps the digits there.
template <class K, class T>
ALIDADE_ALWAYS_INLINE T blend(const K& w, const T& rho2, const T& z, const T& d) {
  const T behind = w * rho2 / (d - z) + (1.0 - 2.0 * w) * z;
  return lane::select(z > 0.0, T(w * d + (1.0 - w) * z), behind);
}

/// d times the derivative of w d + (1 - w) z by z, which is w z + (1 - w) d, in the same way.
template <class K, class T>
ALIDADE_ALWAYS_INLINE T blendSlope(const K& w, const T& rho2, const T& z, const T& d) {
  const T behind = w * rho2 / (d - z) + (1.0 - 2.0 * w) * d;
  return lane::select(z > 0.0, T(w * z + (1.0 - w) * d), behind);
}

/// xi d + z, the depth seen from a point xi behind the sphere's centre, in the same way.
template <class K, class T>
ALIDADE_ALWAYS_INLINE T shiftedDepth(const K& xi, const T& rho2, const T& z, const T& d) {
  const T behind = xi * rho2 / (d - z) + (1.0 - xi) * z;
  return lane::select(z > 0.0, T(xi * d + z), behind);
}

/// w of the condition z > -w d for a one-to-one projection m = rho / (alpha d + (1 - alpha) z) of a sphere or
/// ellipsoid with d = |(rho, z)|, the last step of `ucm`, `eucm` and `double_sphere`. For alpha <= 1/2 it is
/// the pole, where m goes to infinity; above it is the fold, where m is largest (Usenko et al. 2018, section
/// 2.2).
template <class T>
T sphereLimit(const T& alpha) {
  if (alpha > T(0.5)) return (T(1) - alpha) / alpha;
  return alpha / (T(1) - alpha);
}

/// Depth z for which (m, z) points along the ray with the image m, from r2 = m^2: the inverse of that
/// projection (Usenko et al. 2018, section 2.3). NaN beyond the largest m.
template <class T>
ALIDADE_ALWAYS_INLINE T sphereDepth(double alpha, const T& r2) {
  const T root = lane::squareRoot(T(1.0 - (2.0 * alpha - 1.0) * r2));
  return (1.0 - alpha * alpha * r2) / (alpha * root + (1.0 - alpha));
}

}  // namespace detail
}  // namespace alidade
