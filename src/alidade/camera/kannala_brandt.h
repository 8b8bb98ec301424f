// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>

#include "alidade/camera/camera_model.h"
#include "alidade/camera/inverse_start.h"
#include "alidade/camera/wide_angle.h"
#include "alidade/core/lanes.h"

namespace alidade {

/// Fisheye lenses as an odd polynomial in the field angle. With rho = sqrt(X^2 + Y^2) and
/// theta = atan2(rho, Z):
///
///   r  = theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8)
///   mx = r X / rho,  my = r Y / rho
///
/// Parameters: fx, fy (pixels, > 0), cx, cy (pixels), k1, k2, k3, k4 (no unit; OpenCV's fisheye
/// and its order). fx is pixels per radian on the axis. With all k zero the lens is equidistant.
/// Domain: all directions up to the first angle at which r turns back, at most kWideMaxAngle.
/// Inverse: Newton iteration for theta, kept inside a bracket. Source: Kannala and Brandt 2006,
/// A generic camera model and calibration method for conventional, wide-angle, and fish-eye
/// lenses, PAMI 28(8), the radially symmetric model, with the first coefficient absorbed in fx
/// and fy.
struct KannalaBrandt : LensFormula<KannalaBrandt, 4> {
  static constexpr std::string_view kId = "kannala_brandt";
  static constexpr std::string_view kAliases = "fisheye equidistant equi opencv_fisheye pinhole-equi kb4";
  static constexpr std::array<std::string_view, 4> kLensParamNames = {"k1", "k2", "k3", "k4"};
  static constexpr double kMaxAngle = kWideMaxAngle;

  static constexpr LensFamily kFamily = LensFamily::kWide;
  static constexpr bool kIsStiff = false;
  static constexpr bool kIsPolynomial = true;
  static constexpr std::string_view kFlexibleId = "";
  static constexpr std::array<LensVector, 0> kVectors = {};
  static constexpr std::array<SharedLens, 0> kSharedLenses = {};

  template <class T>
  static bool hasValue(const T*, const T* ray) {
    return ray[2] > 0.0 || ray[0] * ray[0] + ray[1] * ray[1] > 0.0;
  }

  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static void formula(const K* k, const T* ray, T* m, T* J_m_ray, T* J_m_lens) {
    const T z = ray[2];
    const T rho2 = ray[0] * ray[0] + ray[1] * ray[1];
    const T q = detail::angleOverRadius(rho2, z);
    const T t2 = q * q * rho2;
    const auto [b, db_dt2] = factor(k, t2);
    m[0] = ray[0] * q * b;
    m[1] = ray[1] * q * b;
    if (J_m_ray != nullptr) {
      const T inverse_n2 = 1.0 / (rho2 + z * z);
      const T dq_ds = detail::angleOverRadiusSlope(rho2, z, q);
      const T df_ds = dq_ds * b + q * db_dt2 * q * z * inverse_n2;
      const T df_dz = -(b + 2.0 * t2 * db_dt2) * inverse_n2;
      detail::radialJacobian(ray, T(q * b), df_ds, df_dz, 1.0, J_m_ray);
    }
    if (J_m_lens != nullptr) {
      T power = q;
      for (int i = 0; i < 4; ++i) {
        power = power * t2;
        J_m_lens[i] = ray[0] * power;
        J_m_lens[4 + i] = ray[1] * power;
      }
    }
  }

  static bool unlens(const double* k, const double* m, double max_angle, double* ray) {
    const double r = std::hypot(m[0], m[1]);
    double theta = 0;
    if (!angleOf(k, r, max_angle + 1e-9, theta)) return false;
    // On the axis, sin(theta) / r is 0 / 0 and its limit is 1.
    const double scale = r > 0 ? std::sin(theta) / r : 1.0;
    detail::makeUnitRay(m[0] * scale, m[1] * scale, std::cos(theta), ray);
    return true;
  }

  using Start = detail::InverseStart;
  static Start makeStart(const double* k, double max_angle) {
    return {[k](double t2) { return factor(k, t2); }, max_angle};
  }
  template <class T>
  ALIDADE_ALWAYS_INLINE static void quickUnlens(const double* k, const Start& start, const T* m,
                                                double max_angle, T* ray) {
    constexpr int kSureSteps = 1;  // most lenses need one; an unpredictable branch costs as much
    constexpr int kMaxSteps = 8;
    constexpr double kRounding = 4 * std::numeric_limits<double>::epsilon();
    const T r2 = m[0] * m[0] + m[1] * m[1];
    const T r = lane::squareRoot(r2);
    T theta = start.scale(r2) * r;
    T error = r;
    for (int i = 0; i < kMaxSteps; ++i) {
      const T t2 = theta * theta;
      const detail::RadialFactor<T> f = factor(k, t2);
      error = theta * f.a - r;
      const T next = theta - error / (f.a + 2.0 * t2 * f.da);
      if (i < kSureSteps) {
        theta = next;
        continue;
      }
      const auto is_open = lane::select(error < 0.0, T(-error), error) > kRounding * r;
      if (!lane::isAny(is_open)) break;
      theta = lane::select(is_open, next, theta);
    }
    const T nothing = r * std::numeric_limits<double>::quiet_NaN();
    theta = lane::select(lane::both(error <= kRounding * r, -error <= kRounding * r), theta, nothing);
    theta = lane::select(lane::both(theta >= 0.0, theta <= max_angle), theta, nothing);
    T sine;
    T cosine;
    lane::sineCosine(theta, sine, cosine);
    const T scale = lane::select(r > 0.0, T(sine / r), T(0.0 * r + 1.0));
    ray[0] = m[0] * scale;
    ray[1] = m[1] * scale;
    ray[2] = cosine;
  }

 private:
  // r / theta and its slope by theta^2.
  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static detail::RadialFactor<T> factor(const K* k, const T& t2) {
    return {1.0 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))),
            k[0] + t2 * (2.0 * k[1] + t2 * (3.0 * k[2] + t2 * (4.0 * k[3])))};
  }

  // Solves r(theta) = r on [0, limit], where r(theta) rises.
  static bool angleOf(const double* k, double r, double limit, double& theta) {
    constexpr int kMaxIterations = 100;
    constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
    const auto radius = [k](double t) { return t * factor(k, t * t).a; };
    if (!(r <= radius(limit))) return false;
    double low = 0;
    double high = limit;
    double last_step = limit;
    theta = std::min(r, limit);
    for (int i = 0; i < kMaxIterations; ++i) {
      const double error = radius(theta) - r;
      if (error == 0.0) return true;
      (error < 0 ? low : high) = theta;
      const double t2 = theta * theta;
      const double slope = 1 + t2 * (3 * k[0] + t2 * (5 * k[1] + t2 * (7 * k[2] + t2 * 9 * k[3])));
      double next = theta - error / slope;
      // Newton's steps may oscillate unless each is at most half the last one.
      const bool is_slow = !(std::abs(next - theta) <= 0.5 * last_step);
      if (is_slow || !(next > low && next < high)) next = 0.5 * (low + high);
      last_step = std::abs(next - theta);
      theta = next;
      if (last_step <= kEpsilon * theta || high - low <= 2 * kEpsilon * high) return true;
    }
    return false;
  }
};

}  // namespace alidade
