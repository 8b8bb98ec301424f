// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string_view>
#include <type_traits>

#include "alidade/camera/camera_model.h"
#include "alidade/camera/wide_angle.h"
#include "alidade/core/lanes.h"

namespace alidade {

namespace detail {

/// A function of a radius x: its value, its derivative, and a number that is positive up to the first fold of
/// the lens.
template <class T>
struct RisingValue {
  T value, slope, rise;
};

/// firstRisingRoot() from a start from which Newton's method converges at once.
/// @return false if not all lanes have a root; x is then of no use
template <class T, class F>
ALIDADE_ALWAYS_INLINE bool quickRisingRoot(const F& f, T& x) {
  constexpr int kMaxSteps = 6;
  constexpr int kSureSteps = 2;  // no start is so good that fewer would do
  constexpr double kRounding = std::numeric_limits<double>::epsilon();
  const T near = 0.5 * x;
  T before = near;
  auto is_near = x == x;
  for (int i = 0; i < kMaxSteps; ++i) {
    const RisingValue<T> at = f(x);
    const T step = at.value / at.slope;
    const T size = lane::select(step < 0.0, T(-step), step);
    x = x - step;
    is_near = lane::both(is_near, lane::both(size <= near, at.rise > 0.0));
    // Errors shrink by their squares: the next step would be size^3 / before^2.
    const auto is_root = lane::both(is_near, size * size * size <= kRounding * x * (before * before));
    before = size;
    if (i >= kSureSteps && lane::isAll(is_root)) return true;
  }
  return false;
}

/// The root of `f` before the first fold, on lanes: Newton's method inside a bracket that grows from 0. A
/// point beyond the root or the fold ends the bracket. NaN without a root. Automatic differentiation passes
/// through the last steps.
template <class T, class F>
ALIDADE_ALWAYS_INLINE T firstRisingRoot(const F& f, const T& start) {
  constexpr int kMaxSteps = 80;
  constexpr double kNear = 1e-11;      // share of x that is left to the last step
  constexpr double kQuadratic = 1e-2;  // share of x below which Newton's steps predict the next
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  constexpr bool kHasDerivatives = !std::is_same_v<T, double> && !std::is_same_v<T, Lanes>;
  T x = start;
  if (!kHasDerivatives && quickRisingRoot(f, x)) return x;
  x = start;
  T low = 0.0 * x;
  T high = low + kInfinity;
  T before = x;  // the last step, if it was not longer than x
  T open = low + 1.0;
  for (int i = 0; i < kMaxSteps; ++i) {
    const RisingValue<T> at = f(x);
    const auto is_beyond = lane::select(at.rise < -at.value, at.rise, T(-at.value)) < 0.0;
    high = lane::select(is_beyond, x, high);
    low = lane::select(is_beyond, low, x);
    const T next = x - at.value / at.slope;
    T step = lane::select(next > x, T(next - x), T(x - next));
    step = lane::select(at.rise > 0.0, step, T(low + kInfinity));
    const T left = lane::select(step < kQuadratic * x, T(step * (step / before) * (step / before)), step);
    open = lane::select(left > kNear * x, open, T(0.0 * low));
    const auto is_open = open > 0.0;
    const T middle = lane::select(high < kInfinity, T(0.5 * (low + high)), T(2.0 * low));
    // Newton's steps may not leave the bracket nor, where it has no end, go far.
    const auto is_inside = lane::both(lane::both(next > low, next < high), next < 4.0 * x + 1.0);
    T to = lane::select(lane::both(is_inside, at.slope > 0.0), next, middle);
    to = lane::select(high - low > 1e-24 * low, to, T(x + lane::kNaN));
    x = lane::select(is_open, to, next);
    before = lane::select(step < x, step, x);
    if (!lane::isAny(is_open)) break;
  }
  x = lane::select(open > 0.0, T(x + lane::kNaN), x);
  for (int i = 0; i < (kHasDerivatives ? 2 : 1); ++i) {
    const RisingValue<T> at = f(x);
    x = x - at.value / at.slope;
  }
  return x;
}

/// The image of a ray in a lens that treats all azimuths alike.
template <class T>
struct RadialImage {
  T scale;  ///< radius in the normalised plane, divided by |(X, Y)|
  T slope;  ///< derivative of that radius by the field angle
};

/// Directions closer to the axis than 1e-15 rad count as that far from it, so that quotients have values.
inline constexpr double kTinySine2 = 1e-30;

}  // namespace detail

/// Common part of the models that treat all azimuths alike. M has image(k, rho2, z, by_lens): the
/// RadialImage of rays with rho2 = X^2 + Y^2, and the derivatives of its scale by the parameters (null: not
/// computed).
template <class M, std::size_t kNum>
struct RadialFormula : LensFormula<M, kNum> {
  static constexpr double kMaxAngle = kWideMaxAngle;
  static constexpr LensFamily kFamily = LensFamily::kWide;
  static constexpr bool kIsStiff = false;
  static constexpr std::string_view kFlexibleId = "";
  static constexpr std::array<LensVector, 0> kVectors = {};

  template <class T>
  static bool hasValue(const T*, const T* ray) {
    return ray[2] > 0.0 || ray[0] * ray[0] + ray[1] * ray[1] > 0.0;
  }

  template <class K, class T>
  ALIDADE_ALWAYS_INLINE static void formula(const K* k, const T* ray, T* m, T* J_m_ray, T* J_m_lens) {
    const T z = ray[2];
    const T rho2 = ray[0] * ray[0] + ray[1] * ray[1];
    T by_lens[kNum];
    const detail::RadialImage<T> r = M::image(k, rho2, z, J_m_lens == nullptr ? nullptr : by_lens);
    m[0] = ray[0] * r.scale;
    m[1] = ray[1] * r.scale;
    if (J_m_ray != nullptr) {
      const T n2 = rho2 + z * z;
      const T by_angle = r.slope / n2;
      const T by_rho2 = (by_angle * z - r.scale) / (rho2 + detail::kTinySine2 * n2);
      detail::radialJacobian(ray, r.scale, by_rho2, T(-by_angle), 0.5, J_m_ray);
    }
    if (J_m_lens != nullptr) {
      for (std::size_t i = 0; i < kNum; ++i) {
        J_m_lens[i] = ray[0] * by_lens[i];
        J_m_lens[kNum + i] = ray[1] * by_lens[i];
      }
    }
  }
};

/// Common part of those whose definition leads from the pixel to the ray. M has radiusOf(k, sine, cosine),
/// the radius of a field angle, by firstRisingRoot(); sight(k, r, side, depth), the ray (side, depth) of a
/// radius with any positive length; and lastRadius(k), the radius at which the definition ends or folds.
template <class M, std::size_t kNum>
struct StatedInverseFormula : RadialFormula<M, kNum> {
  /// The inverse has all its digits, and the projection enough of them, much nearer to the fold.
  static constexpr double kEndMargin = 4e-8;

  static double maxAngle(const double* k) {
    constexpr int kNumRadii = 500;
    constexpr double kSameRadius = 1e-3;  // far more than rounding, and less than from one root to another
    constexpr double kStraightBack = kWideMaxAngle - 1e-9;
    const double last = M::lastRadius(k);
    const auto angleOf = [k](double r) {
      double side = 0;
      double depth = 0;
      M::sight(k, r, side, depth);
      return std::atan2(side, depth);
    };
    // The search for the image of an angle may miss its first root where the lens folds again farther out.
    double before = 0;
    for (int i = 1; i < kNumRadii; ++i) {
      const double r = last * i / kNumRadii;
      const double angle = angleOf(r);
      if (angle >= kStraightBack) return kWideMaxAngle;
      const double image = M::radiusOf(k, std::sin(angle), std::cos(angle));
      if (!(std::abs(image - r) <= kSameRadius * r)) return before;
      before = angle;
    }
    const double end = angleOf(last);
    return end >= kStraightBack ? kWideMaxAngle : end;
  }

  /// The radius at the end of the domain: beyond it, a lens may fold back to angles inside the cone.
  struct Start {
    double radius = 0;
  };
  static Start makeStart(const double* k, double max_angle) {
    return {M::radiusOf(k, std::sin(max_angle), std::cos(max_angle))};
  }

  template <class T>
  ALIDADE_ALWAYS_INLINE static void quickUnlens(const double* k, const Start& start, const T* m, double,
                                                T* ray) {
    const T r = lane::squareRoot(T(m[0] * m[0] + m[1] * m[1]));
    T side;
    T depth;
    M::sight(k, r, side, depth);
    const T nothing = lane::select(r <= start.radius, T(0.0 * r), T(r + lane::kNaN));
    const T scale = lane::select(r > 0.0, T(side / r), T(0.0 * r + 1.0));
    detail::makeUnitRay(T(scale * m[0] + nothing), T(scale * m[1] + nothing), depth, ray);
  }

  static bool unlens(const double* k, const double* m, double max_angle, double* ray) {
    Start start = makeStart(k, max_angle);
    // A ray on the rim of the domain survives rounding.
    start.radius *= 1 + 1e-9;
    quickUnlens(k, start, m, max_angle, ray);
    return std::isfinite(ray[0]);
  }
};

}  // namespace alidade
