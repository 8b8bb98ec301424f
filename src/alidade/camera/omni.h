// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>

#include "alidade/camera/camera_model.h"
#include "alidade/camera/perspective_plane.h"
#include "alidade/camera/wide_angle.h"
#include "alidade/core/lanes.h"

namespace alidade {

/// Mei's model for mirrors and fisheye lenses: the unit sphere seen from a point xi behind its centre, then
/// radial and tangential distortion. With d = sqrt(X^2 + Y^2 + Z^2), x = X / (Z + xi d), y = Y / (Z + xi d),
/// r2 = x^2 + y^2 and a = 1 + k1 r2 + k2 r2^2:
///
///   mx = x a + 2 p1 x y + p2 (r2 + 2 x^2)
///   my = y a + p1 (r2 + 2 y^2) + 2 p2 x y
///
/// Parameters: fx, fy (pixels, > 0), cx, cy (pixels), xi (>= 0), k1, k2, p1, p2; no units. fx / (1
/// + xi) is pixels per radian on the axis. Without distortion it is `ucm` with alpha = xi / (1 +
/// xi). Domain: Z > -w d with w = xi up to xi = 1 (a pole) and w = 1 / xi above (a fold), the
/// plane of x and y up to a distance of 1000, and field angle below the first fold of the
/// distortion over all azimuths. Inverse: safeguarded Newton iteration for x, y, on which the
/// distortion is the gradient of a potential (see `radtan`); then closed form. Source: Mei and
/// Rives 2007, Single view point omnidirectional camera calibration from planar grids, ICRA,
/// section II.
struct Omni : LensFormula<Omni, 5> {
  static constexpr std::string_view kId = "omni";
  static constexpr std::string_view kAliases = "mei omnidir omni-radtan";
  static constexpr std::array<std::string_view, 5> kLensParamNames = {"xi", "k1", "k2", "p1", "p2"};
  static constexpr std::array<ParamRange, 5> kLensRanges = {
      ParamRange{.min = 0.0, .max = std::numeric_limits<double>::infinity()}};
  static constexpr std::array<double, 5> kStartLens = {1, 0, 0, 0, 0};
  static constexpr double kMaxAngle = kWideMaxAngle;

  // To a model without distortion.
  static double toUcm(const double* k, double* ucm) {
    ucm[0] = k[0] / (1 + k[0]);
    return k[1] == 0 && k[2] == 0 && k[3] == 0 && k[4] == 0 ? 1 / (1 + k[0]) : 0.0;
  }
  static double fromUcm(const double* ucm, double* k) {
    if (!(ucm[0] < 1)) return 0.0;
    k[0] = ucm[0] / (1 - ucm[0]);
    return 1 + k[0];
  }

  static constexpr LensFamily kFamily = LensFamily::kWide;
  static constexpr bool kIsStiff = false;
  static constexpr bool kIsPolynomial = false;
  static constexpr std::string_view kFlexibleId = "";
  static constexpr std::array<LensVector, 1> kVectors = {LensVector{4, 3}};
  static constexpr std::array<SharedLens, 2> kSharedLenses = {SharedLens{"radtan"},
                                                              SharedLens{"ucm", toUcm, fromUcm}};

  static double maxAngle(const double* k) {
    const double xi = k[0];
    if (!(xi >= 0.0)) return 0.0;
    // sin(angle) = tan(flat) (cos(angle) + xi) at the edge of the plane's usable part, beyond which x, y lose
    // digits.
    const double flat = kPerspectiveMaxAngle;
    const double s = xi * std::sin(flat);
    const double angle = s < 1.0 ? flat + std::asin(s) : std::acos(-1.0 / xi);
    return std::min(kMaxAngle, angle);
  }

  template <class T>
  static bool hasValue(const T* k, const T* ray) {
    const T xi = k[0];
    const T z = ray[2];
    const T d = lane::squareRoot(T(ray[0] * ray[0] + ray[1] * ray[1] + z * z));
    if (!(xi >= 0.0)) return false;
    if (xi > 1.0) return xi * z > -d;
    return z > -xi * d;
  }

  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static void formula(const K* k, const T* ray, T* m, T* J_m_ray, T* J_m_lens) {
    const K xi = k[0];
    const T z = ray[2];
    const T rho2 = ray[0] * ray[0] + ray[1] * ray[1];
    const T d = lane::squareRoot(T(rho2 + z * z));
    const T f = 1.0 / detail::shiftedDepth(xi, rho2, z, d);
    const T x = ray[0] * f;
    const T y = ray[1] * f;
    const detail::WarpSample<T> s = warp(k, x, y);
    m[0] = s.mx;
    m[1] = s.my;
    if (J_m_ray != nullptr) {
      T J[6];  // derivative of (x, y) by the ray
      const T by_d = xi / d;
      detail::radialJacobian(ray, f, T(-0.5 * f * f * by_d), T(-f * f * (1.0 + by_d * z)), 1.0, J);
      detail::warpJacobian(s, J, J_m_ray);
    }
    if (J_m_lens != nullptr) {
      const T r2 = x * x + y * y;
      const T shrink = -f * d;  // d x / d xi = shrink x
      J_m_lens[0] = shrink * (s.dmx_dx * x + s.dmx_dy * y);
      J_m_lens[1] = x * r2;
      J_m_lens[2] = x * r2 * r2;
      J_m_lens[5] = shrink * (s.dmy_dx * x + s.dmy_dy * y);
      J_m_lens[6] = y * r2;
      J_m_lens[7] = y * r2 * r2;
      detail::tangentialDerivatives(x, y, J_m_lens + 3, J_m_lens + 8);
    }
  }

  static bool unlens(const double* k, const double* m, double max_angle, double* ray) {
    const double xi = k[0];
    if (!(xi >= 0.0)) return false;
    // Adds a nanoradian so that a ray on the rim of the domain survives rounding. At the fold of the sphere,
    // the radius has its maximum and hardly changes.
    const double rim = max_angle + 1e-9;
    const double rho_max = planeRadius(xi, rim);
    double x = 0;
    double y = 0;
    const auto f = [k](double px, double py) { return warp(k, px, py); };
    if (!detail::invertWarp(f, m[0], m[1], rho_max, x, y)) return false;
    onSphere(xi, x, y, ray);
    return std::isfinite(ray[2]);
  }

  using Start = detail::InverseStart;
  static Start makeStart(const double* k, double max_angle) {
    return {[k](double r2) { return radial(k, r2); },
            std::min(planeRadius(k[0], max_angle), detail::kMaxStartRadius)};
  }
  template <class T>
  ALIDADE_ALWAYS_INLINE static void quickUnlens(const double* k, const Start& start, const T* m, double,
                                                T* ray) {
    T x;
    T y;
    detail::quickInvertWarp([k](const T& px, const T& py) ALIDADE_INLINE_LAMBDA { return warp(k, px, py); },
                            start, m[0], m[1], x, y);
    onSphere(k[0], x, y, ray);
  }

 private:
  static double planeRadius(double xi, double angle) { return std::sin(angle) / (std::cos(angle) + xi); }

  // The unit ray that meets the plane at (x, y); NaN beyond the sphere's rim.
  template <class T>
  ALIDADE_ALWAYS_INLINE static void onSphere(double xi, const T& x, const T& y, T* ray) {
    const T r2 = x * x + y * y;
    const T length = (xi + lane::squareRoot(T(1.0 + (1.0 - xi * xi) * r2))) / (1.0 + r2);
    detail::makeUnitRay(T(length * x), T(length * y), T(length - xi), ray);
  }

  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static detail::RadialFactor<T> radial(const K* k, const T& r2) {
    return {1.0 + r2 * (k[1] + r2 * k[2]), k[1] + 2.0 * r2 * k[2]};
  }

  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static detail::WarpSample<T> warp(const K* k, const T& x, const T& y) {
    return detail::radialTangentialWarp(x, y, radial(k, T(x * x + y * y)), k[3], k[4]);
  }
};

}  // namespace alidade
