// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "alidade/camera/camera_model.h"
#include "alidade/camera/inverse_start.h"
#include "alidade/camera/stated_inverse.h"
#include "alidade/camera/wide_angle.h"
#include "alidade/core/lanes.h"

namespace alidade {

/// Inverse of the models that state a radius r(theta) in the normalised plane for a field angle: Newton
/// iteration for theta, kept inside a bracket. M has radiusOf(k, theta); Base is the rest of the model.
template <class M, class Base>
struct AnglePolynomial : Base {
  static bool unlens(const double* k, const double* m, double max_angle, double* ray) {
    const double r = std::hypot(m[0], m[1]);
    double theta = 0;
    if (!angleOf(k, r, max_angle + 1e-9, theta)) return false;
    // On the axis, sin(theta) / r is 0 / 0 and its limit is 1.
    const double scale = r > 0 ? std::sin(theta) / r : 1.0;
    detail::makeUnitRay(m[0] * scale, m[1] * scale, std::cos(theta), ray);
    return true;
  }

  using Start = detail::InverseStart;
  static Start makeStart(const double* k, double max_angle) {
    const auto radial = [k](double t2) {
      const double theta = std::sqrt(t2);
      return detail::RadialFactor<double>{M::radiusOf(k, theta).value / theta, 0};
    };
    return {radial, max_angle};
  }
  template <class T>
  ALIDADE_ALWAYS_INLINE static void quickUnlens(const double* k, const Start& start, const T* m,
                                                double max_angle, T* ray) {
    constexpr int kSureSteps = 1;  // most lenses need one; an unpredictable branch costs as much
    constexpr int kMaxSteps = 8;
    constexpr double kRounding = 4 * std::numeric_limits<double>::epsilon();
    const T r2 = m[0] * m[0] + m[1] * m[1];
    const T r = lane::squareRoot(r2);
    T theta = start.scale(r2) * r;
    T error = r;
    for (int i = 0; i < kMaxSteps; ++i) {
      const detail::RisingValue<T> at = M::radiusOf(k, theta);
      error = at.value - r;
      const T next = theta - error / at.slope;
      if (i < kSureSteps) {
        theta = next;
        continue;
      }
      const auto is_open = lane::select(error < 0.0, T(-error), error) > kRounding * r;
      if (!lane::isAny(is_open)) break;
      theta = lane::select(is_open, next, theta);
    }
    const T nothing = r * std::numeric_limits<double>::quiet_NaN();
    theta = lane::select(lane::both(error <= kRounding * r, -error <= kRounding * r), theta, nothing);
    theta = lane::select(lane::both(theta >= 0.0, theta <= max_angle), theta, nothing);
    T sine;
    T cosine;
    lane::sineCosine(theta, sine, cosine);
    const T scale = lane::select(r > 0.0, T(sine / r), T(0.0 * r + 1.0));
    ray[0] = m[0] * scale;
    ray[1] = m[1] * scale;
    ray[2] = cosine;
  }

 private:
  // Solves r(theta) = r on [0, limit], where r(theta) rises.
  static bool angleOf(const double* k, double r, double limit, double& theta) {
    constexpr int kMaxIterations = 100;
    constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
    if (!(r <= M::radiusOf(k, limit).value)) return false;
    double low = 0;
    double high = limit;
    double last_step = limit;
    theta = std::min(r, limit);
    for (int i = 0; i < kMaxIterations; ++i) {
      const detail::RisingValue<double> at = M::radiusOf(k, theta);
      const double error = at.value - r;
      if (error == 0.0) return true;
      (error < 0 ? low : high) = theta;
      double next = theta - error / at.slope;
      // Newton's steps may oscillate unless each is at most half the last one.
      const bool is_slow = !(std::abs(next - theta) <= 0.5 * last_step);
      if (is_slow || !(next > low && next < high)) next = 0.5 * (low + high);
      last_step = std::abs(next - theta);
      theta = next;
      if (last_step <= kEpsilon * theta || high - low <= 2 * kEpsilon * high) return true;
    }
    return false;
  }
};

}  // namespace alidade
