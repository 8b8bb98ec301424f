// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "alidade/camera/camera_model.h"
#include "alidade/camera/perspective_plane.h"
#include "alidade/camera/polynomial_root.h"
#include "alidade/core/lanes.h"

namespace alidade {

/// Radial distortion as a quotient of polynomials, with the tangential terms of `radtan`. With x = X/Z,
/// y = Y/Z, r2 = x^2 + y^2 and
/// a = (1 + k1 r2 + k2 r2^2 + k3 r2^3) / (1 + k4 r2 + k5 r2^2 + k6 r2^3):
///
///   mx = x a + 2 p1 x y + p2 (r2 + 2 x^2)
///   my = y a + p1 (r2 + 2 y^2) + 2 p2 x y
///
/// Parameters: fx, fy (pixels, > 0), cx, cy (pixels), k1, k2, p1, p2, k3, k4, k5, k6 (no
/// unit; this is OpenCV's order). Domain: Z > 0, the denominator positive, and field angle
/// below the first fold over all azimuths: the first root of the denominator is a pole, at
/// which the projection goes to infinity; beyond it, the formula does not describe a lens.
/// The map is the gradient of a potential; see `radtan`. Inverse: safeguarded Newton
/// iteration inside that disc. Source: Claus and Fitzgibbon 2005, A rational function lens
/// distortion model for general cameras, CVPR, for the idea; the formula is that of OpenCV's
/// CALIB_RATIONAL_MODEL.
struct Rational : PlaneFormula<Rational, 8> {
  static constexpr std::string_view kId = "rational";
  static constexpr std::string_view kAliases = "rational_polynomial full_opencv opencv8 pinhole-radtan8";
  static constexpr std::array<std::string_view, 8> kLensParamNames = {"k1", "k2", "p1", "p2",
                                                                      "k3", "k4", "k5", "k6"};

  static constexpr bool kIsStiff = false;
  static constexpr bool kIsPolynomial = false;
  static constexpr std::string_view kFlexibleId = "";
  static constexpr std::array<LensVector, 1> kVectors = {LensVector{3, 2}};
  static constexpr std::array<SharedLens, 1> kSharedLenses = {SharedLens{"radtan"}};

  /// The pole, the first root of the denominator: where numerator and denominator nearly cancel, it is
  /// too narrow to be found by sampling.
  static double maxAngle(const double* k) {
    const double r2_max = std::pow(std::tan(kMaxAngle), 2);
    return std::min(
        kMaxAngle,
        std::atan(std::sqrt(detail::firstPolynomialRoot(std::array{1.0, k[5], k[6], k[7]}, r2_max))));
  }

  template <class T>
  static bool hasValue(const T* k, const T* ray) {
    if (!(ray[2] > 0.0)) return false;
    const T x = ray[0] / ray[2];
    const T y = ray[1] / ray[2];
    const T r2 = x * x + y * y;
    return 1.0 + r2 * (k[5] + r2 * (k[6] + r2 * k[7])) > 0.0;
  }

  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static detail::RadialFactor<T> radial(const K* k, const T& r2) {
    const T numerator = 1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
    const T scale = 1.0 / (1.0 + r2 * (k[5] + r2 * (k[6] + r2 * k[7])));
    const T slope_up = k[0] + r2 * (2.0 * k[1] + r2 * (3.0 * k[4]));
    const T slope_down = k[5] + r2 * (2.0 * k[6] + r2 * (3.0 * k[7]));
    const T a = numerator * scale;
    return {a, (slope_up - a * slope_down) * scale};
  }

  /// The distortion of the plane and its Jacobian, short of the pole.
  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static detail::WarpSample<T> warp(const K* k, const T& x, const T& y) {
    return detail::radialTangentialWarp(x, y, radial(k, T(x * x + y * y)), k[2], k[3]);
  }

  /// Derivatives of mx and my by the eight parameters.
  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static void lensDerivatives(const K* k, const T& x, const T& y, T* dmx, T* dmy) {
    const T r2 = x * x + y * y;
    const T numerator = 1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
    const T scale = 1.0 / (1.0 + r2 * (k[5] + r2 * (k[6] + r2 * k[7])));
    const T up = r2 * scale;                 // d a / d k1
    const T down = -up * numerator * scale;  // d a / d k4
    const T da[8] = {up, up * r2, up, up, up * r2 * r2, down, down * r2, down * r2 * r2};
    for (int i = 0; i < 8; ++i) {
      dmx[i] = x * da[i];
      dmy[i] = y * da[i];
    }
    detail::tangentialDerivatives(x, y, dmx + 2, dmy + 2);
  }
};

}  // namespace alidade
