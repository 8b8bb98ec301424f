// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <vector>

namespace alidade::detail {

/// The roots in (0, limit] of c0 + c1 x + c2 x^2 + ... with a change of sign, ascending. Between the roots of
/// its derivative a polynomial is monotone, so a change of sign there brackets exactly one root.
template <std::size_t kSize>
std::vector<double> polynomialRoots(const std::array<double, kSize>& c, double limit) {
  const auto value = [&c](double x) {
    double sum = 0;
    for (std::size_t i = kSize; i-- > 0;) sum = sum * x + c[i];
    return sum;
  };
  std::vector<double> ends;
  if constexpr (kSize > 2) {
    std::array<double, kSize - 1> slope{};
    for (std::size_t i = 1; i < kSize; ++i) slope[i - 1] = static_cast<double>(i) * c[i];
    ends = polynomialRoots(slope, limit);
  }
  ends.push_back(limit);
  std::vector<double> roots;
  double low = 0;
  for (const double end : ends) {
    const bool is_positive = value(low) > 0;
    if ((value(end) > 0) != is_positive) {
      double high = end;
      for (int i = 0; i < 200 && high - low > 1e-16 * high; ++i) {
        const double middle = 0.5 * (low + high);
        ((value(middle) > 0) == is_positive ? low : high) = middle;
      }
      roots.push_back(low);
    }
    low = end;
  }
  return roots;
}

/// The first of these roots, or infinity.
template <std::size_t kSize>
double firstPolynomialRoot(const std::array<double, kSize>& c, double limit) {
  const std::vector<double> roots = polynomialRoots(c, limit);
  return roots.empty() ? std::numeric_limits<double>::infinity() : roots.front();
}

}  // namespace alidade::detail
