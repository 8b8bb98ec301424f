// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "alidade/camera/polynomial_root.h"
#include "alidade/camera/stated_inverse.h"
#include "alidade/core/lanes.h"

namespace alidade::detail {

/// Common part of the models that state the ray of a point (X, Y) of the normalised plane, R = |(X, Y)|, as
///
///   (X, Y, h(R)),  h(R) = 1 + c1 R^e1 + c2 R^e2 + ...
///
/// M has kPowers, the ascending exponents, which begin with 2. The image of a field angle is the first root
/// of R cos(theta) = h(R) sin(theta). Domain: field angles up to the first R at which theta(R) turns back, or
/// R = 1000, where powers still keep their digits.
template <class M, std::size_t kNum>
struct RayPolynomial : StatedInverseFormula<M, kNum> {
  static constexpr bool kIsPolynomial = false;

  static double lastRadius(const double* k) {
    constexpr double kFarthest = 1000;
    // theta(R) rises while h - R h' is positive.
    std::array<double, static_cast<std::size_t>(M::kPowers.back()) + 1> rise{1.0};
    for (std::size_t i = 0; i < kNum; ++i)
      rise[static_cast<std::size_t>(M::kPowers[i])] = (1 - M::kPowers[i]) * k[i];
    return std::min(kFarthest, firstPolynomialRoot(rise, kFarthest));
  }

  template <class T>
  ALIDADE_ALWAYS_INLINE static void sight(const double* k, const T& r, T& side, T& depth) {
    side = r;
    depth = depthOf(k, r).value;
  }

  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static T radiusOf(const K* k, const T& sine, const T& cosine) {
    // The root for the quadratic term alone, or one that is nearly a perspective, starts well.
    constexpr double kLeastBend = -0.05;
    const K bend = lane::select(k[0] < kLeastBend, k[0], K(0.0 * k[0] + kLeastBend));
    const T root = lane::squareRoot(T(cosine * cosine - 4.0 * bend * sine * sine));
    return firstRisingRoot(
        [&](const T& r) ALIDADE_INLINE_LAMBDA {
          const Depth<T> h = depthOf(k, r);
          return RisingValue<T>{r * cosine - sine * h.value, cosine - sine * h.slope, h.value - r * h.slope};
        },
        T(2.0 * sine / (cosine + root)));
  }

  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static RadialImage<T> image(const K* k, const T& rho2, const T& z, T* by_lens) {
    const T n2 = rho2 + z * z;
    const T inverse_n = 1.0 / lane::squareRoot(n2);
    const T sine = lane::squareRoot(T(rho2 + kTinySine2 * n2)) * inverse_n;
    const T cosine = z * inverse_n;
    const T r = radiusOf(k, sine, cosine);
    const Depth<T> h = depthOf(k, r);
    const T inverse_slope = 1.0 / (cosine - sine * h.slope);
    if (by_lens != nullptr) {
      T power = inverse_slope * inverse_n;
      int exponent = 0;
      for (std::size_t i = 0; i < kNum; ++i) {
        for (; exponent < M::kPowers[i]; ++exponent) power = power * r;
        by_lens[i] = power;
      }
    }
    return {r * inverse_n / sine, (r * sine + h.value * cosine) * inverse_slope};
  }

 private:
  template <class T>
  struct Depth {
    T value, slope;
  };
  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static Depth<T> depthOf(const K* k, const T& r) {
    T value = 0.0 * r;
    T slope = value;
    int exponent = M::kPowers.back();
    for (std::size_t i = kNum; i-- > 0;) {
      for (; exponent > M::kPowers[i]; --exponent) {
        slope = slope * r + value;
        value = value * r;
      }
      value = value + k[i];
    }
    for (; exponent > 0; --exponent) {
      slope = slope * r + value;
      value = value * r;
    }
    return {value + 1.0, slope};
  }
};

}  // namespace alidade::detail
