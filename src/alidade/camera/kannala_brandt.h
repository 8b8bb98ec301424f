// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <string_view>

#include "alidade/camera/angle_polynomial.h"
#include "alidade/camera/camera_model.h"
#include "alidade/camera/inverse_start.h"
#include "alidade/camera/stated_inverse.h"
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
struct KannalaBrandt : AnglePolynomial<KannalaBrandt, LensFormula<KannalaBrandt, 4>> {
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

  /// r / theta and its slope by theta^2.
  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static detail::RadialFactor<T> factor(const K* k, const T& t2) {
    return {1.0 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))),
            k[0] + t2 * (2.0 * k[1] + t2 * (3.0 * k[2] + t2 * (4.0 * k[3])))};
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

  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static detail::RisingValue<T> radiusOf(const K* k, const T& theta) {
    const T t2 = theta * theta;
    const detail::RadialFactor<T> f = factor(k, t2);
    const T slope = f.a + 2.0 * t2 * f.da;
    return {theta * f.a, slope, slope};
  }
};

}  // namespace alidade
