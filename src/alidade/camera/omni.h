// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>

#include "alidade/camera/camera_model.h"
#include "alidade/camera/perspective_plane.h"
#include "alidade/camera/unified_sphere.h"
#include "alidade/camera/wide_angle.h"

namespace alidade {

/// Mei's model for mirrors and fisheye lenses: the unit sphere seen from a point xi behind its centre, then
/// radial and tangential distortion. With d = sqrt(X^2 + Y^2 + Z^2), x = X / (Z + xi d), y = Y / (Z + xi d),
/// r2 = x^2 + y^2 and a = 1 + k1 r2 + k2 r2^2:
///
///   mx = x a + 2 p1 x y + p2 (r2 + 2 x^2)
///   my = y a + p1 (r2 + 2 y^2) + 2 p2 x y
///
/// Parameters: fx, fy (pixels, > 0), cx, cy (pixels), xi (>= 0), k1, k2, p1, p2; no units. fx / (1 + xi) is
/// pixels a radian on the axis. Without distortion it is `ucm` with alpha = xi / (1 + xi).
/// Domain: Z > -w d with w = xi up to xi = 1 (a pole) and w = 1 / xi above (a fold), the plane of x and y no
/// farther out than 1000, and field angle below the first fold of the distortion over all azimuths.
/// Inverse: safeguarded Newton iteration for x, y, on which the distortion is the gradient of a potential
/// (see `radtan`); then closed form.
/// Source: Mei and Rives 2007, Single view point omnidirectional camera calibration from planar grids, ICRA,
/// section II.
struct Omni {
  static constexpr std::string_view kId = "omni";
  static constexpr int kNumLensParams = 5;
  static constexpr std::array<std::string_view, 5> kLensParamNames = {"xi", "k1", "k2", "p1", "p2"};
  static constexpr std::array<ParamRange, 5> kLensRanges = {
      ParamRange{.min = 0.0, .max = std::numeric_limits<double>::infinity()}};
  static constexpr std::array<double, 5> kStartLens = {1, 0, 0, 0, 0};
  static constexpr double kMaxAngle = kWideMaxAngle;
  static constexpr bool kIsOneToOneWithoutFold = true;

  static double maxAngle(const double* k) {
    const double xi = k[0];
    if (!(xi >= 0.0)) return 0.0;
    // sin(angle) = tan(flat) (cos(angle) + xi) where x, y leave the plane's part on which digits last.
    const double flat = kPerspectiveMaxAngle;
    const double s = xi * std::sin(flat);
    const double angle = s < 1.0 ? flat + std::asin(s) : std::acos(-1.0 / xi);
    return std::min(kMaxAngle, angle);
  }
  static bool isAxiallySymmetric(const double* k) { return k[3] == 0.0 && k[4] == 0.0; }

  template <class T>
  static bool lens(const T* k, const T* ray, T* m) {
    using std::sqrt;
    const T rho2 = ray[0] * ray[0] + ray[1] * ray[1];
    const T d = sqrt(rho2 + ray[2] * ray[2]);
    if (!isSeen(k[0], d, ray[2])) return false;
    const T depth = detail::shiftedDepth(k[0], rho2, ray[2], d);
    const T x = ray[0] / depth;
    const T y = ray[1] / depth;
    const T r2 = x * x + y * y;
    const T a = T(1) + r2 * (k[1] + r2 * k[2]);
    const T xy2 = T(2) * x * y;
    m[0] = x * a + k[3] * xy2 + k[4] * (r2 + T(2) * x * x);
    m[1] = y * a + k[3] * (r2 + T(2) * y * y) + k[4] * xy2;
    return true;
  }

  static bool lensJacobian(const double* k, const double* ray, double* m, double* J_m_ray, double* J_m_lens) {
    const double rho2 = ray[0] * ray[0] + ray[1] * ray[1];
    const double d = std::sqrt(rho2 + ray[2] * ray[2]);
    if (!isSeen(k[0], d, ray[2])) return false;
    const double f = 1 / detail::shiftedDepth(k[0], rho2, ray[2], d);
    const double x = ray[0] * f;
    const double y = ray[1] * f;
    const detail::WarpSample s = warp(k, x, y);
    m[0] = s.mx;
    m[1] = s.my;
    if (J_m_ray != nullptr) {
      double J[6];  // of (x, y) by the ray
      detail::radialJacobian(ray, f, -f * f * k[0] / (2 * d), -f * f * (1 + k[0] * ray[2] / d), 1.0, J);
      for (int i = 0; i < 3; ++i) {
        J_m_ray[i] = s.dmx_dx * J[i] + s.dmx_dy * J[3 + i];
        J_m_ray[3 + i] = s.dmy_dx * J[i] + s.dmy_dy * J[3 + i];
      }
    }
    if (J_m_lens != nullptr) {
      const double r2 = x * x + y * y;
      const double xy2 = 2 * x * y;
      const double shrink = -f * d;  // d x / d xi = shrink x
      J_m_lens[0] = shrink * (s.dmx_dx * x + s.dmx_dy * y);
      J_m_lens[1] = x * r2;
      J_m_lens[2] = x * r2 * r2;
      J_m_lens[3] = xy2;
      J_m_lens[4] = r2 + 2 * x * x;
      J_m_lens[5] = shrink * (s.dmy_dx * x + s.dmy_dy * y);
      J_m_lens[6] = y * r2;
      J_m_lens[7] = y * r2 * r2;
      J_m_lens[8] = r2 + 2 * y * y;
      J_m_lens[9] = xy2;
    }
    return true;
  }

  static bool unlens(const double* k, const double* m, double max_angle, double* ray) {
    const double xi = k[0];
    if (!(xi >= 0.0)) return false;
    // The last nanoradian lets a ray on the rim of the domain come back despite rounding; at the sphere's own
    // fold the radius has its maximum and hardly changes.
    const double rim = max_angle + 1e-9;
    const double rho_max = std::sin(rim) / (std::cos(rim) + xi);
    double x = 0;
    double y = 0;
    const auto f = [k](double px, double py) { return warp(k, px, py); };
    if (!detail::invertWarp(f, m[0], m[1], rho_max, x, y)) return false;
    const double r2 = x * x + y * y;
    const double root2 = 1 + (1 - xi * xi) * r2;
    if (!(root2 >= 0.0)) return false;
    const double length = (xi + std::sqrt(root2)) / (1 + r2);
    return detail::makeUnitRay(length * x, length * y, length - xi, ray);
  }

 private:
  template <class T>
  static bool isSeen(const T& xi, const T& d, const T& z) {
    if (!(xi >= T(0))) return false;
    if (xi > T(1)) return xi * z > -d;
    return z > -xi * d;
  }

  static detail::WarpSample warp(const double* k, double x, double y) {
    const double r2 = x * x + y * y;
    const double a = 1 + r2 * (k[1] + r2 * k[2]);
    const double da = k[1] + 2 * r2 * k[2];  // da / d(r2)
    const double p1 = k[3];
    const double p2 = k[4];
    detail::WarpSample s;
    s.mx = x * a + 2 * p1 * x * y + p2 * (r2 + 2 * x * x);
    s.my = y * a + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y;
    s.dmx_dx = a + 2 * x * x * da + 2 * p1 * y + 6 * p2 * x;
    s.dmx_dy = 2 * x * y * da + 2 * p1 * x + 2 * p2 * y;
    s.dmy_dx = s.dmx_dy;
    s.dmy_dy = a + 2 * y * y * da + 6 * p1 * y + 2 * p2 * x;
    return s;
  }
};

}  // namespace alidade
