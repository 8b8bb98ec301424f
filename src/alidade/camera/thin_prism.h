// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "alidade/camera/camera_model.h"
#include "alidade/camera/perspective_plane.h"
#include "alidade/camera/rational.h"
#include "alidade/core/lanes.h"

namespace alidade {

/// `rational` with the terms of a thin prism, for a sensor or a lens element that is tilted. With x, y, r2
/// and the map (rx, ry) of `rational`:
///
///   mx = rx + s1 r2 + s2 r2^2
///   my = ry + s3 r2 + s4 r2^2
///
/// Parameters: fx, fy (pixels, > 0), cx, cy (pixels), k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4 (no
/// unit; this is OpenCV's order). Domain: as `rational`. The prism terms are not a gradient, so the image of
/// the rim of the cone is checked in addition to the determinant: a map without folds that takes the rim to a
/// curve without crossings is one-to-one. Inverse: safeguarded Newton iteration inside that disc. Source:
/// Weng, Cohen and Herniou 1992, Camera calibration with distortion models and accuracy evaluation, PAMI
/// 14(10), section II; the formula is that of OpenCV's CALIB_THIN_PRISM_MODEL.
struct ThinPrism : LensFormula<ThinPrism> {
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
  static bool hasValue(const T* k, const T* ray) {
    return Rational::hasValue(k, ray);
  }

  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static void formula(const K* k, const T* ray, T* m, T* J_m_ray, T* J_m_lens) {
    const T iz = 1.0 / ray[2];
    const T x = ray[0] * iz;
    const T y = ray[1] * iz;
    const detail::WarpSample<T> s = warp(k, x, y);
    m[0] = s.mx;
    m[1] = s.my;
    if (J_m_ray != nullptr) detail::warpJacobian(s, x, y, iz, J_m_ray);
    if (J_m_lens != nullptr) {
      Rational::lensDerivatives(k, x, y, J_m_lens, J_m_lens + 12);
      const T r2 = x * x + y * y;
      const T zero = 0.0 * r2;
      J_m_lens[8] = r2;
      J_m_lens[9] = r2 * r2;
      J_m_lens[10] = zero;
      J_m_lens[11] = zero;
      J_m_lens[20] = zero;
      J_m_lens[21] = zero;
      J_m_lens[22] = r2;
      J_m_lens[23] = r2 * r2;
    }
  }

  static bool unlens(const double* k, const double* m, double max_angle, double* ray) {
    const auto f = [k](double x, double y) { return warp(k, x, y); };
    return detail::unwarpRay(f, m, max_angle, ray);
  }

  using Start = detail::InverseStart;
  static Start makeStart(const double* k, double max_angle) {
    return {[k](double r2) { return Rational::radial(k, r2); },
            std::min(std::tan(max_angle), detail::kMaxStartRadius)};
  }
  template <class T>
  ALIDADE_ALWAYS_INLINE static void quickUnlens(const double* k, const Start& start, const T* m, double,
                                                T* ray) {
    detail::quickUnwarpRay([k](const T& x, const T& y) ALIDADE_INLINE_LAMBDA { return warp(k, x, y); }, start,
                           m, ray);
  }

 private:
  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static detail::WarpSample<T> warp(const K* k, const T& x, const T& y) {
    detail::WarpSample<T> s = Rational::warp(k, x, y);
    const T r2 = x * x + y * y;
    const T slope_x = 2.0 * (k[8] + 2.0 * r2 * k[9]);
    const T slope_y = 2.0 * (k[10] + 2.0 * r2 * k[11]);
    s.mx = s.mx + r2 * (k[8] + r2 * k[9]);
    s.my = s.my + r2 * (k[10] + r2 * k[11]);
    s.dmx_dx = s.dmx_dx + slope_x * x;
    s.dmx_dy = s.dmx_dy + slope_x * y;
    s.dmy_dx = s.dmy_dx + slope_y * x;
    s.dmy_dy = s.dmy_dy + slope_y * y;
    return s;
  }
};

}  // namespace alidade
