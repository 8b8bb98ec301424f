// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "alidade/camera/camera_model.h"
#include "alidade/camera/wide_angle.h"
#include "alidade/core/lanes.h"

namespace alidade {

/// Double sphere model: the ray meets a unit sphere, then one shifted by xi, then the plane. With
/// d1 = sqrt(X^2 + Y^2 + Z^2), h = xi d1 + Z and d2 = sqrt(X^2 + Y^2 + h^2):
///
///   mx = X / (alpha d2 + (1 - alpha) h),  my = Y / (alpha d2 + (1 - alpha) h)
///
/// Parameters: fx, fy (pixels, > 0), cx, cy (pixels), xi (-0.99 to 1; at -1 the axis has no value), alpha
/// (0 to 1); no units. xi = 0 is `ucm`.
/// Domain: h > -w d2 with w = alpha / (1 - alpha) up to alpha = 1/2 (a pole) and w = (1 - alpha) / alpha
/// above (a fold). The angle psi of (rho, h) rises with the field angle theta, theta = psi + asin(xi sin
/// psi), so this is a cone of a known half-angle. The paper's condition on Z is a little stricter. Inverse:
/// closed form. Source: Usenko, Demmel and Cremers 2018, The double sphere camera model, 3DV, section 3.
struct DoubleSphere : LensFormula<DoubleSphere, 2> {
  static constexpr std::string_view kId = "double_sphere";
  static constexpr std::string_view kAliases = "ds ds-none";
  static constexpr std::array<std::string_view, 2> kLensParamNames = {"xi", "alpha"};
  static constexpr std::array<ParamRange, 2> kLensRanges = {ParamRange{.min = -0.99, .max = 1.0},
                                                            ParamRange{.min = 0.0, .max = 1.0}};
  static constexpr std::array<double, 2> kStartLens = {0.0, 0.5};
  static constexpr double kMaxAngle = kWideMaxAngle;

  static constexpr LensFamily kFamily = LensFamily::kWide;
  static constexpr bool kIsStiff = true;
  static constexpr bool kIsPolynomial = false;
  static constexpr std::string_view kFlexibleId = "kannala_brandt";
  static constexpr std::array<LensVector, 0> kVectors = {};
  static constexpr std::array<SharedLens, 1> kSharedLenses = {SharedLens{"ucm"}};

  static double maxAngle(const double* k) {
    if (!isInRange(k[0], k[1])) return 0.0;
    const double w = detail::sphereLimit(k[1]);
    const double psi = std::acos(-w);
    return std::min(kMaxAngle, psi + std::asin(k[0] * std::sin(psi)));
  }

  template <class T>
  static bool hasValue(const T* k, const T* ray) {
    if (!isInRange(k[0], k[1])) return false;
    const T rho2 = ray[0] * ray[0] + ray[1] * ray[1];
    if (!(ray[2] > 0.0) && !(rho2 > 0.0)) return false;
    const T d1 = lane::squareRoot(T(rho2 + ray[2] * ray[2]));
    const T h = detail::shiftedDepth(k[0], rho2, ray[2], d1);
    return h > -detail::sphereLimit(k[1]) * lane::squareRoot(T(rho2 + h * h));
  }

  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static void formula(const K* k, const T* ray, T* m, T* J_m_ray, T* J_m_lens) {
    const K xi = k[0];
    const K alpha = k[1];
    const T z = ray[2];
    const T rho2 = ray[0] * ray[0] + ray[1] * ray[1];
    const T d1 = lane::squareRoot(T(rho2 + z * z));
    const T h = detail::shiftedDepth(xi, rho2, z, d1);
    const T d2 = lane::squareRoot(T(rho2 + h * h));
    const T f = 1.0 / detail::blend(alpha, rho2, h, d2);
    m[0] = ray[0] * f;
    m[1] = ray[1] * f;
    if (J_m_ray == nullptr && J_m_lens == nullptr) return;
    const T slope = -f * f;
    const T inverse_d2 = 1.0 / d2;
    const T ddepth_dh = detail::blendSlope(alpha, rho2, h, d2) * inverse_d2;
    if (J_m_ray != nullptr) {
      const T xi_by_d1 = xi / d1;
      const T df_ds = 0.5 * slope * (alpha * inverse_d2 + ddepth_dh * xi_by_d1);
      const T df_dz = slope * ddepth_dh * (xi_by_d1 * z + 1.0);
      detail::radialJacobian(ray, f, df_ds, df_dz, 1.0, J_m_ray);
    }
    if (J_m_lens != nullptr) {
      const T df_dxi = slope * ddepth_dh * d1;
      const T df_dalpha = slope * (d2 - h);
      J_m_lens[0] = ray[0] * df_dxi;
      J_m_lens[1] = ray[0] * df_dalpha;
      J_m_lens[2] = ray[1] * df_dxi;
      J_m_lens[3] = ray[1] * df_dalpha;
    }
  }

  template <class T>
  ALIDADE_ALWAYS_INLINE static void quickUnlens(const double* k, const Start&, const T* m, double, T* ray) {
    const double xi = k[0];
    const T r2 = m[0] * m[0] + m[1] * m[1];
    const T h = detail::sphereDepth(k[1], r2);
    // Distance from the centre of the shifted sphere along (m, h) to the unit sphere.
    const T length = (h * xi + lane::squareRoot(T(h * h + (1.0 - xi * xi) * r2))) / (h * h + r2);
    detail::makeUnitRay(T(length * m[0]), T(length * m[1]), T(length * h - xi), ray);
  }

 private:
  template <class T>
  static bool isInRange(const T& xi, const T& alpha) {
    return xi >= kLensRanges[0].min && xi <= 1.0 && alpha >= 0.0 && alpha <= 1.0;
  }
};

}  // namespace alidade
