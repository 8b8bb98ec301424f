// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "alidade/camera/camera_model.h"
#include "alidade/camera/polynomial_root.h"
#include "alidade/camera/stated_inverse.h"
#include "alidade/core/lanes.h"

namespace alidade {

/// Fisheye lenses whose field angle is stated as a polynomial of the radius r in the normalised plane:
///
///   theta = r (1 + k1 r + k2 r^2 + k3 r^3 + k4 r^4 + k5 r^5)
///   mx = r X / rho,  my = r Y / rho
///
/// Parameters: fx, fy (pixels per radian on the axis, > 0), cx, cy (pixels), k1 to k5 (no unit). NVIDIA's
/// bw_poly b1 s + b2 s^2 + ... of s pixels is fx = 1 / b1, k_i = b_(i+1) fx^(i+1). Domain: up to the first
/// radius at which theta turns back, and kWideMaxAngle. Inverse: closed form. Forward: safeguarded Newton
/// iteration for r. Source: NVIDIA DriveWorks, FTheta camera model with POLYNOMIAL_TYPE
/// PIXELDISTANCE_TO_ANGLE.
struct FThetaInverse : StatedInverseFormula<FThetaInverse, 5> {
  static constexpr std::string_view kId = "ftheta_inverse";
  static constexpr std::string_view kAliases = "bw_poly";
  static constexpr bool kIsCandidate = false;
  static constexpr std::array<std::string_view, 5> kLensParamNames = {"k1", "k2", "k3", "k4", "k5"};
  static constexpr bool kIsPolynomial = true;
  static constexpr std::array<SharedLens, 0> kSharedLenses = {};

  /// theta of a radius.
  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static detail::RisingValue<T> angleOf(const K* k, const T& r) {
    T a = 0.0 * r + k[4];
    T da = 0.0 * r;
    for (int i = 3; i >= 0; --i) {
      da = da * r + a;
      a = a * r + k[i];
    }
    da = da * r + a;
    a = a * r + 1.0;
    const T slope = a + r * da;
    return {r * a, slope, slope};
  }

  static double lastRadius(const double* k) {
    constexpr double kFarthest = 1000;
    const double fold = detail::firstPolynomialRoot(
        std::array{1.0, 2 * k[0], 3 * k[1], 4 * k[2], 5 * k[3], 6 * k[4]}, kFarthest);
    const double straight_back =
        detail::firstPolynomialRoot(std::array{-kWideMaxAngle, 1.0, k[0], k[1], k[2], k[3], k[4]}, kFarthest);
    return std::min({kFarthest, fold, straight_back});
  }

  template <class T>
  ALIDADE_ALWAYS_INLINE static void sight(const double* k, const T& r, T& side, T& depth) {
    const T theta = angleOf(k, r).value;
    lane::sineCosine(theta, side, depth);
  }

  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static T radiusOf(const K* k, const T& sine, const T& cosine) {
    using std::atan2;
    return radiusOfAngle(k, T(atan2(sine, cosine)));
  }

  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static detail::RadialImage<T> image(const K* k, const T& rho2, const T& z,
                                                            T* by_lens) {
    const T rho = lane::squareRoot(T(rho2 + detail::kTinySine2 * (rho2 + z * z)));
    const T inverse_rho = 1.0 / rho;
    const T r = radiusOfAngle(k, T(rho * detail::angleOverRadius(rho2, z)));
    const T by_angle = 1.0 / angleOf(k, r).slope;
    if (by_lens != nullptr) {
      T power = -r * by_angle * inverse_rho;
      for (int i = 0; i < 5; ++i) by_lens[i] = power = power * r;
    }
    return {r * inverse_rho, by_angle};
  }

 private:
  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static T radiusOfAngle(const K* k, const T& theta) {
    return detail::firstRisingRoot(
        [&](const T& r) ALIDADE_INLINE_LAMBDA {
          detail::RisingValue<T> at = angleOf(k, r);
          at.value = at.value - theta;
          return at;
        },
        theta);
  }
};

}  // namespace alidade
