// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "alidade/core/lanes.h"

namespace alidade::detail {

/// The factor by which a lens scales a radius rho, a function of rho^2: r = rho a(rho^2).
template <class T>
struct RadialFactor {
  T a;
  T da;  ///< da / d(rho^2)
};

/// An initial guess for the radius rho that a lens maps to r: rho / r as a polynomial of r^2, from its values
/// at Chebyshev nodes. Accurate to about 1e-5 for ordinary lenses, and only an initial guess in any case.
class InverseStart {
 public:
  InverseStart() { c_[0] = 1; }

  /// @param radial  RadialFactor<double> of rho^2, rising on (0, rho_max)
  template <class Radial>
  InverseStart(const Radial& radial, double rho_max) : InverseStart() {
    const auto radiusOf = [&](double rho) { return rho * radial(rho * rho).a; };
    // At a fold the inverse has the slope of a square root, which no polynomial follows.
    const double end = 0.95 * rho_max;
    const double w_max = radiusOf(end) * radiusOf(end);
    if (!(w_max > 0.0) || !std::isfinite(w_max)) return;
    std::array<double, kSize> node{};
    std::array<double, kSize> value{};
    for (std::size_t i = 0; i < kSize; ++i) {
      node[i] = 0.5 - 0.5 * std::cos(std::numbers::pi * (static_cast<double>(i) + 0.5) / kSize);
      const double r = std::sqrt(w_max * node[i]);
      double low = 0;
      double high = end;
      for (int k = 0; k < 50; ++k) {
        const double middle = 0.5 * (low + high);
        (radiusOf(middle) < r ? low : high) = middle;
      }
      value[i] = 0.5 * (low + high) / r;
    }
    // Newton's divided differences, then powers.
    for (std::size_t j = 1; j < kSize; ++j) {
      for (std::size_t i = kSize - 1; i >= j; --i)
        value[i] = (value[i] - value[i - 1]) / (node[i] - node[i - j]);
    }
    std::array<double, kSize> c{};
    for (std::size_t i = kSize; i-- > 0;) {
      for (std::size_t k = kSize - 1; k > 0; --k) c[k] = c[k - 1] - node[i] * c[k];
      c[0] = value[i] - node[i] * c[0];
    }
    if (!std::all_of(c.begin(), c.end(), [](double x) { return std::isfinite(x); })) return;
    c_ = c;
    inverse_w_max_ = 1 / w_max;
  }

  /// rho / r; beyond the end of the fit, its last value.
  template <class T>
  ALIDADE_ALWAYS_INLINE T scale(const T& r2) const {
    T w = r2 * inverse_w_max_;
    w = lane::select(w < 1.0, w, T(0.0 * w + 1.0));
    T sum = 0.0 * w + c_[kSize - 1];
    for (std::size_t i = kSize - 1; i-- > 0;) sum = sum * w + c_[i];
    return sum;
  }

 private:
  static constexpr std::size_t kSize = 9;
  std::array<double, kSize> c_{};
  double inverse_w_max_ = 0;
};

}  // namespace alidade::detail
