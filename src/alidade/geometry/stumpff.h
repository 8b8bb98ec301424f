// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace alidade::detail {

/// Below this value the Stumpff functions are computed as series. At 1, the closed form of c_5 (near 1/120)
/// has lost two digits, which affects only the last bit of the matrices that use it.
inline constexpr double kStumpffSeriesLimit = 1.0;

/// n! c_n(x) = 1 - x / ((n+1)(n+2)) (1 - x / ((n+3)(n+4)) (1 - ...)), from the innermost term outwards.
template <class T>
T stumpffSeries(const T& x, int n) {
  constexpr int kNumTerms = 8;  // for c_4 and x <= 1 the first term left out is 1/22! = 1e-21
  T sum(1.0);
  for (int k = kNumTerms; k > 0; --k) {
    sum = T(1.0) - x * sum / T(static_cast<double>((n + 2 * k - 1) * (n + 2 * k)));
  }
  return sum;
}

/// The Stumpff functions c_n(x) = sum_k (-x)^k / (n + 2k)! for n = 0..5 and x >= 0 (Danby, Fundamentals of
/// Celestial Mechanics, 1988). With x = angle^2 they are all the coefficients of the exponential maps and
/// their Jacobians: c_0 = cos(angle), c_1 = sin(angle) / angle, c_2 = (1 - cos(angle)) / angle^2, c_3 =
/// (angle - sin(angle)) / angle^3 and so on, without 0/0 at angle 0. They are analytic in x, so automatic
/// differentiation works at x = 0; with the angle itself as variable it would not. Absolute error about
/// 1e-16, on both sides of the switch between series and closed form.
template <class T>
std::array<T, 6> stumpff(const T& x) {
  using std::cos;
  using std::sin;
  using std::sqrt;
  constexpr std::array<double, 6> kInverseFactorial = {1.0,       1.0,        1.0 / 2.0,
                                                       1.0 / 6.0, 1.0 / 24.0, 1.0 / 120.0};
  std::array<T, 6> c;
  // Both directions use c_n = 1/n! - x c_{n+2}: downwards it is stable for a small x, upwards for a large
  // one.
  if (x <= T(kStumpffSeriesLimit)) {
    c[5] = T(kInverseFactorial[5]) * stumpffSeries(x, 5);
    c[4] = T(kInverseFactorial[4]) * stumpffSeries(x, 4);
    for (std::size_t n = 4; n-- > 0;) c[n] = T(kInverseFactorial[n]) - x * c[n + 2];
  } else {
    const T root = sqrt(x);
    c[0] = cos(root);
    c[1] = sin(root) / root;
    for (std::size_t n = 0; n < 4; ++n) c[n + 2] = (T(kInverseFactorial[n]) - c[n]) / x;
  }
  return c;
}

}  // namespace alidade::detail
