// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>

#include "alidade/camera/camera_model.h"
#include "alidade/camera/wide_angle.h"
#include "alidade/core/lanes.h"

namespace alidade {

/// Extended unified camera model: central projection through an ellipsoid. With d = sqrt(beta (X^2 + Y^2) +
/// Z^2):
///
///   mx = X / (alpha d + (1 - alpha) Z),  my = Y / (alpha d + (1 - alpha) Z)
///
/// Parameters: fx, fy (pixels, > 0), cx, cy (pixels), alpha (0 to 1), beta (> 0); no units. alpha = 0 is the
/// perspective projection, beta = 1 is `ucm`.
/// Domain: Z > -w d with w = alpha / (1 - alpha) up to alpha = 1/2 (a pole) and w = (1 - alpha) / alpha above
/// (a fold), a cone whose half-angle is known in closed form. Inverse: closed form.
/// Source: Khomutenko, Garcia and Martinet 2016, An enhanced unified camera model, RA-L 1(1), section II.
struct Eucm : LensFormula<Eucm, 2> {
  static constexpr std::string_view kId = "eucm";
  static constexpr std::string_view kAliases = "extended_unified eucm-none";
  static constexpr std::array<std::string_view, 2> kLensParamNames = {"alpha", "beta"};
  static constexpr std::array<ParamRange, 2> kLensRanges = {
      ParamRange{.min = 0.0, .max = 1.0},
      ParamRange{.min = 1e-3, .max = std::numeric_limits<double>::infinity()}};
  static constexpr std::array<double, 2> kStartLens = {0.5, 1.0};
  static constexpr double kMaxAngle = kWideMaxAngle;

  static double toUcm(const double* k, double* ucm) {
    ucm[0] = k[0];
    return k[1] == 1 ? 1.0 : 0.0;
  }
  static double fromUcm(const double* ucm, double* k) {
    k[0] = ucm[0];
    k[1] = 1;
    return 1.0;
  }
  // Without alpha, beta has no effect.
  static double toPinhole(const double* k, double*) { return k[0] == 0 ? 1.0 : 0.0; }

  static constexpr LensFamily kFamily = LensFamily::kWide;
  static constexpr bool kIsStiff = true;
  static constexpr bool kIsPolynomial = false;
  static constexpr std::string_view kFlexibleId = "kannala_brandt";
  static constexpr std::array<LensVector, 0> kVectors = {};
  static constexpr std::array<SharedLens, 2> kSharedLenses = {SharedLens{"ucm", toUcm, fromUcm},
                                                              SharedLens{"pinhole", toPinhole}};

  static double maxAngle(const double* k) {
    if (!isInRange(k[0], k[1])) return 0.0;
    const double w = detail::sphereLimit(k[0]);
    return std::min(kMaxAngle, std::atan2(std::sqrt((1 - w) * (1 + w)), -w * std::sqrt(k[1])));
  }

  template <class T>
  static bool hasValue(const T* k, const T* ray) {
    if (!isInRange(k[0], k[1])) return false;
    const T rho2 = ray[0] * ray[0] + ray[1] * ray[1];
    if (!(ray[2] > 0.0) && !(rho2 > 0.0)) return false;
    return ray[2] > -detail::sphereLimit(k[0]) * lane::squareRoot(T(k[1] * rho2 + ray[2] * ray[2]));
  }

  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static void formula(const K* k, const T* ray, T* m, T* J_m_ray, T* J_m_lens) {
    const K alpha = k[0];
    const K beta = k[1];
    const T z = ray[2];
    const T rho2 = ray[0] * ray[0] + ray[1] * ray[1];
    const T d = lane::squareRoot(T(beta * rho2 + z * z));
    const T f = 1.0 / detail::blend(alpha, T(beta * rho2), z, d);
    m[0] = ray[0] * f;
    m[1] = ray[1] * f;
    if (J_m_ray == nullptr && J_m_lens == nullptr) return;
    const T slope = -f * f / (2.0 * d);
    if (J_m_ray != nullptr) {
      const T df_ds = slope * (alpha * beta);
      const T df_dz = 2.0 * slope * detail::blendSlope(alpha, T(beta * rho2), z, d);
      detail::radialJacobian(ray, f, df_ds, df_dz, 1.0, J_m_ray);
    }
    if (J_m_lens != nullptr) {
      const T df_dalpha = -f * f * (d - z);
      const T df_dbeta = slope * alpha * rho2;
      J_m_lens[0] = ray[0] * df_dalpha;
      J_m_lens[1] = ray[0] * df_dbeta;
      J_m_lens[2] = ray[1] * df_dalpha;
      J_m_lens[3] = ray[1] * df_dbeta;
    }
  }

  template <class T>
  ALIDADE_ALWAYS_INLINE static void quickUnlens(const double* k, const Start&, const T* m, double, T* ray) {
    const T z = detail::sphereDepth(k[0], T(k[1] * (m[0] * m[0] + m[1] * m[1])));
    detail::makeUnitRay(m[0], m[1], z, ray);
  }

 private:
  template <class T>
  static bool isInRange(const T& alpha, const T& beta) {
    return alpha >= 0.0 && alpha <= 1.0 && beta >= kLensRanges[1].min;
  }
};

}  // namespace alidade
