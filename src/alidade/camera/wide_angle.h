// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <numbers>

namespace alidade {

/// Models that see behind the camera's own plane stop here: straight back all azimuths meet in one ray, which
/// has a circle for an image and not a pixel.
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
  if (z > T(0) && rho2 < T(kSmallTangent2) * z * z) {
    const T t2 = rho2 / (z * z);
    return (T(1) + t2 * (T(-1.0 / 3.0) + t2 * T(0.2))) / z;
  }
  const T rho = sqrt(rho2);
  return atan2(rho, z) / rho;
}

/// Derivative of angleOverRadius, of value q, by rho2. Its derivative by z is -1 / (rho2 + z^2).
inline double angleOverRadiusSlope(double rho2, double z, double q) {
  if (z > 0 && rho2 < kSmallTangent2 * z * z) {
    const double t2 = rho2 / (z * z);
    return (-1.0 / 3.0 + 0.4 * t2) / (z * z * z);
  }
  return (z / (rho2 + z * z) - q) / (2 * rho2);
}

/// Jacobian (row-major 2x3) by the ray of m = (x, y) F(s, z), where s = scale (x^2 + y^2), from F and its
/// derivatives. All lenses without tangential terms have this form.
inline void radialJacobian(const double* ray, double f, double df_ds, double df_dz, double scale,
                           double* J_m_ray) {
  const double x = ray[0];
  const double y = ray[1];
  const double g = 2 * scale * df_ds;
  J_m_ray[0] = f + g * x * x;
  J_m_ray[1] = g * x * y;
  J_m_ray[2] = df_dz * x;
  J_m_ray[3] = J_m_ray[1];
  J_m_ray[4] = f + g * y * y;
  J_m_ray[5] = df_dz * y;
}

/// Scales (x, y, z) to unit length. False if that is impossible.
inline bool makeUnitRay(double x, double y, double z, double* ray) {
  const double norm = std::hypot(x, y, z);
  if (!(norm > 0.0) || !std::isfinite(norm)) return false;
  ray[0] = x / norm;
  ray[1] = y / norm;
  ray[2] = z / norm;
  return true;
}

}  // namespace detail
}  // namespace alidade
