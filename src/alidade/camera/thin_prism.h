// SPDX-License-Identifier: MIT
#pragma once

#include <array>
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
struct ThinPrism : PlaneFormula<ThinPrism, 12> {
  static constexpr std::string_view kId = "thin_prism";
  static constexpr std::string_view kAliases = "opencv12";
  static constexpr std::array<std::string_view, 12> kLensParamNames = {"k1", "k2", "p1", "p2", "k3", "k4",
                                                                       "k5", "k6", "s1", "s2", "s3", "s4"};
  static constexpr bool kIsOneToOneWithoutFold = false;

  static constexpr bool kIsStiff = false;
  static constexpr bool kIsPolynomial = true;  // unlike `rational`: the prism and the numerator dominate
  static constexpr std::string_view kFlexibleId = "";
  static constexpr std::array<LensVector, 3> kVectors = {LensVector{3, 2}, LensVector{8, 10},
                                                         LensVector{9, 11}};
  static constexpr std::array<SharedLens, 1> kSharedLenses = {SharedLens{"rational"}};

  static double maxAngle(const double* k) { return Rational::maxAngle(k); }

  template <class T>
  static bool hasValue(const T* k, const T* ray) {
    return Rational::hasValue(k, ray);
  }

  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static detail::RadialFactor<T> radial(const K* k, const T& r2) {
    return Rational::radial(k, r2);
  }

  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static detail::WarpSample<T> warp(const K* k, const T& x, const T& y) {
    detail::WarpSample<T> s = Rational::warp(k, x, y);
    detail::addPrism(k + 8, x, y, s);
    return s;
  }

  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static void lensDerivatives(const K* k, const T& x, const T& y, T* dmx, T* dmy) {
    Rational::lensDerivatives(k, x, y, dmx, dmy);
    detail::prismDerivatives(x, y, dmx + 8, dmy + 8);
  }
};

}  // namespace alidade
