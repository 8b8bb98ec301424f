// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <string_view>

#include "alidade/camera/camera_model.h"
#include "alidade/camera/perspective_plane.h"
#include "alidade/camera/rational.h"

namespace alidade {

/// `rational` with the terms of a thin prism, for a sensor or a lens element that is tilted. With x, y, r2
/// and the map (rx, ry) of `rational`:
///
///   mx = rx + s1 r2 + s2 r2^2
///   my = ry + s3 r2 + s4 r2^2
///
/// Parameters: fx, fy (pixels, > 0), cx, cy (pixels), k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4 (no
/// unit; this is OpenCV's order). Domain: as `rational`. The prism's terms are no gradient, so beside the
/// determinant the image of the cone's rim is looked at: a map without folds that takes the rim to a curve
/// without crossings is one-to-one. Inverse: safeguarded Newton iteration inside that disc. Source: Weng,
/// Cohen and Herniou 1992, Camera calibration with distortion models and accuracy evaluation, PAMI 14(10),
/// section II; the formula is that of OpenCV's CALIB_THIN_PRISM_MODEL.
struct ThinPrism {
  static constexpr std::string_view kId = "thin_prism";
  static constexpr int kNumLensParams = 12;
  static constexpr std::array<std::string_view, 12> kLensParamNames = {"k1", "k2", "p1", "p2", "k3", "k4",
                                                                       "k5", "k6", "s1", "s2", "s3", "s4"};
  static constexpr std::array<ParamRange, 12> kLensRanges = {};
  static constexpr std::array<double, 12> kStartLens = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
  static constexpr double kMaxAngle = kPerspectiveMaxAngle;
  static constexpr bool kIsOneToOneWithoutFold = false;

  static double maxAngle(const double* k) { return Rational::maxAngle(k); }
  static bool isAxiallySymmetric(const double* k) {
    return Rational::isAxiallySymmetric(k) && k[8] == 0.0 && k[9] == 0.0 && k[10] == 0.0 && k[11] == 0.0;
  }

  template <class T>
  static bool lens(const T* k, const T* ray, T* m) {
    if (!Rational::lens(k, ray, m)) return false;
    const T x = ray[0] / ray[2];
    const T y = ray[1] / ray[2];
    const T r2 = x * x + y * y;
    m[0] += r2 * (k[8] + r2 * k[9]);
    m[1] += r2 * (k[10] + r2 * k[11]);
    return true;
  }

  static bool lensJacobian(const double* k, const double* ray, double* m, double* J_m_ray, double* J_m_lens) {
    double J_m_rational[16];
    if (!Rational::lensJacobian(k, ray, m, nullptr, J_m_lens == nullptr ? nullptr : J_m_rational))
      return false;
    const double iz = 1.0 / ray[2];
    const double x = ray[0] * iz;
    const double y = ray[1] * iz;
    const detail::WarpSample s = warp(k, x, y);
    m[0] = s.mx;
    m[1] = s.my;
    if (J_m_ray != nullptr) detail::warpJacobian(s, x, y, iz, J_m_ray);
    if (J_m_lens != nullptr) {
      const double r2 = x * x + y * y;
      for (int i = 0; i < 8; ++i) {
        J_m_lens[i] = J_m_rational[i];
        J_m_lens[12 + i] = J_m_rational[8 + i];
      }
      const std::array<double, 4> prism_x = {r2, r2 * r2, 0, 0};
      const std::array<double, 4> prism_y = {0, 0, r2, r2 * r2};
      std::copy(prism_x.begin(), prism_x.end(), J_m_lens + 8);
      std::copy(prism_y.begin(), prism_y.end(), J_m_lens + 20);
    }
    return true;
  }

  static bool unlens(const double* k, const double* m, double max_angle, double* ray) {
    const auto f = [k](double x, double y) { return warp(k, x, y); };
    return detail::unwarpRay(f, m, max_angle, ray);
  }

 private:
  static detail::WarpSample warp(const double* k, double x, double y) {
    detail::WarpSample s = Rational::warp(k, x, y);
    const double r2 = x * x + y * y;
    const double slope_x = 2 * (k[8] + 2 * r2 * k[9]);
    const double slope_y = 2 * (k[10] + 2 * r2 * k[11]);
    s.mx += r2 * (k[8] + r2 * k[9]);
    s.my += r2 * (k[10] + r2 * k[11]);
    s.dmx_dx += slope_x * x;
    s.dmx_dy += slope_x * y;
    s.dmy_dx += slope_y * x;
    s.dmy_dy += slope_y * y;
    return s;
  }
};

}  // namespace alidade
