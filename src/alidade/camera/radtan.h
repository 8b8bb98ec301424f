// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "alidade/camera/camera_model.h"
#include "alidade/camera/perspective_plane.h"
#include "alidade/core/lanes.h"

namespace alidade {

/// Radial and tangential (Brown-Conrady) distortion of the perspective plane. With x = X/Z, y = Y/Z,
/// r2 = x^2 + y^2 and a = 1 + k1 r2 + k2 r2^2 + k3 r2^3:
///
///   mx = x a + 2 p1 x y + p2 (r2 + 2 x^2)
///   my = y a + p1 (r2 + 2 y^2) + 2 p2 x y
///
/// Parameters: fx, fy (pixels, > 0), cx, cy (pixels), k1, k2, p1, p2, k3 (no unit; this is OpenCV's order).
/// Domain: Z > 0 and field angle below the first fold over all azimuths. The map is the gradient of a
/// potential, so its Jacobian is symmetric and a positive determinant on a disc makes it one-to-one there.
/// Inverse: safeguarded Newton iteration inside that disc.
/// Source: Brown 1966, Decentering distortion of lenses, Photogrammetric Engineering 32(3).
struct Radtan : LensFormula<Radtan> {
  static constexpr std::string_view kId = "radtan";
  static constexpr int kNumLensParams = 5;
  static constexpr std::array<std::string_view, 5> kLensParamNames = {"k1", "k2", "p1", "p2", "k3"};
  static constexpr std::array<ParamRange, 5> kLensRanges = {};
  static constexpr std::array<double, 5> kStartLens = {0, 0, 0, 0, 0};
  static constexpr double kMaxAngle = kPerspectiveMaxAngle;
  static constexpr bool kIsOneToOneWithoutFold = true;

  static double maxAngle(const double*) { return kMaxAngle; }
  static bool isAxiallySymmetric(const double* k) { return k[2] == 0.0 && k[3] == 0.0; }

  template <class T>
  static bool hasValue(const T*, const T* ray) {
    return ray[2] > 0.0;
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
      const T r2 = x * x + y * y;
      const T r4 = r2 * r2;
      const T xy2 = 2.0 * x * y;
      J_m_lens[0] = x * r2;
      J_m_lens[1] = x * r4;
      J_m_lens[2] = xy2;
      J_m_lens[3] = r2 + 2.0 * x * x;
      J_m_lens[4] = x * r4 * r2;
      J_m_lens[5] = y * r2;
      J_m_lens[6] = y * r4;
      J_m_lens[7] = r2 + 2.0 * y * y;
      J_m_lens[8] = xy2;
      J_m_lens[9] = y * r4 * r2;
    }
  }

  static bool unlens(const double* k, const double* m, double max_angle, double* ray) {
    const auto f = [k](double x, double y) { return warp(k, x, y); };
    return detail::unwarpRay(f, m, max_angle, ray);
  }

  using Start = detail::InverseStart;
  static Start makeStart(const double* k, double max_angle) {
    return {[k](double r2) { return radial(k, r2); }, std::min(std::tan(max_angle), detail::kMaxStartRadius)};
  }
  template <class T>
  ALIDADE_ALWAYS_INLINE static void quickUnlens(const double* k, const Start& start, const T* m, double,
                                                T* ray) {
    detail::quickUnwarpRay([k](const T& x, const T& y) ALIDADE_INLINE_LAMBDA { return warp(k, x, y); }, start,
                           m, ray);
  }

 private:
  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static detail::RadialFactor<T> radial(const K* k, const T& r2) {
    return {1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4])), k[0] + r2 * (2.0 * k[1] + r2 * (3.0 * k[4]))};
  }

  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static detail::WarpSample<T> warp(const K* k, const T& x, const T& y) {
    return detail::radialTangentialWarp(x, y, radial(k, T(x * x + y * y)), k[2], k[3]);
  }
};

}  // namespace alidade
