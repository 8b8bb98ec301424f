// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "alidade/camera/camera_model.h"
#include "alidade/camera/unified_sphere.h"
#include "alidade/camera/wide_angle.h"

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
struct DoubleSphere {
  static constexpr std::string_view kId = "double_sphere";
  static constexpr int kNumLensParams = 2;
  static constexpr std::array<std::string_view, 2> kLensParamNames = {"xi", "alpha"};
  static constexpr std::array<ParamRange, 2> kLensRanges = {ParamRange{.min = -0.99, .max = 1.0},
                                                            ParamRange{.min = 0.0, .max = 1.0}};
  static constexpr std::array<double, 2> kStartLens = {0.0, 0.5};
  static constexpr double kMaxAngle = kWideMaxAngle;
  static constexpr bool kIsOneToOneWithoutFold = true;

  static double maxAngle(const double* k) {
    if (!isInRange(k[0], k[1])) return 0.0;
    const double w = detail::sphereLimit(k[1]);
    const double psi = std::acos(-w);
    return std::min(kMaxAngle, psi + std::asin(k[0] * std::sin(psi)));
  }
  static bool isAxiallySymmetric(const double*) { return true; }

  template <class T>
  static bool lens(const T* k, const T* ray, T* m) {
    using std::sqrt;
    if (!isInRange(k[0], k[1])) return false;
    const T rho2 = ray[0] * ray[0] + ray[1] * ray[1];
    if (!(ray[2] > T(0)) && !(rho2 > T(0))) return false;
    const T h = detail::shiftedDepth(k[0], rho2, ray[2], sqrt(rho2 + ray[2] * ray[2]));
    const T d2 = sqrt(rho2 + h * h);
    if (!(h > -detail::sphereLimit(k[1]) * d2)) return false;
    const T depth = detail::blend(k[1], rho2, h, d2);
    m[0] = ray[0] / depth;
    m[1] = ray[1] / depth;
    return true;
  }

  static bool lensJacobian(const double* k, const double* ray, double* m, double* J_m_ray, double* J_m_lens) {
    const double xi = k[0];
    const double alpha = k[1];
    if (!isInRange(xi, alpha)) return false;
    const double z = ray[2];
    const double rho2 = ray[0] * ray[0] + ray[1] * ray[1];
    if (!(z > 0.0) && !(rho2 > 0.0)) return false;
    const double d1 = std::sqrt(rho2 + z * z);
    const double h = detail::shiftedDepth(xi, rho2, z, d1);
    const double d2 = std::sqrt(rho2 + h * h);
    if (!(h > -detail::sphereLimit(alpha) * d2)) return false;
    const double f = 1 / detail::blend(alpha, rho2, h, d2);
    m[0] = ray[0] * f;
    m[1] = ray[1] * f;
    const double ddepth_dh = detail::blendSlope(alpha, rho2, h, d2) / d2;
    if (J_m_ray != nullptr) {
      const double df_ds = -f * f * (alpha / d2 + ddepth_dh * xi / d1) / 2;
      const double df_dz = -f * f * ddepth_dh * (xi * z / d1 + 1);
      detail::radialJacobian(ray, f, df_ds, df_dz, 1.0, J_m_ray);
    }
    if (J_m_lens != nullptr) {
      const double df_dxi = -f * f * ddepth_dh * d1;
      const double df_dalpha = -f * f * (d2 - h);
      J_m_lens[0] = ray[0] * df_dxi;
      J_m_lens[1] = ray[0] * df_dalpha;
      J_m_lens[2] = ray[1] * df_dxi;
      J_m_lens[3] = ray[1] * df_dalpha;
    }
    return true;
  }

  static bool unlens(const double* k, const double* m, double, double* ray) {
    const double xi = k[0];
    if (!isInRange(xi, k[1])) return false;
    const double r2 = m[0] * m[0] + m[1] * m[1];
    double h = 0;
    if (!detail::sphereDepth(k[1], r2, h)) return false;
    // From the shifted sphere's centre along (m, h) to the unit sphere.
    const double n2 = h * h + r2;
    const double length = (h * xi + std::sqrt(h * h + (1 - xi * xi) * r2)) / n2;
    return detail::makeUnitRay(length * m[0], length * m[1], length * h - xi, ray);
  }

 private:
  template <class T>
  static bool isInRange(const T& xi, const T& alpha) {
    return xi >= T(kLensRanges[0].min) && xi <= T(1) && alpha >= T(0) && alpha <= T(1);
  }
};

}  // namespace alidade
