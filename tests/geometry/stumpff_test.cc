// SPDX-License-Identifier: MIT
#include "alidade/geometry/stumpff.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <limits>

namespace alidade {
namespace {

using detail::kStumpffSeriesLimit;
using detail::stumpff;

constexpr double kValueTolerance = 5e-16;       // a few roundings of numbers up to 1
constexpr double kDerivativeTolerance = 2e-15;  // the closed form divides by x once more for each order

/// The defining series, in extended precision. For x <= 60 its largest term is below 1e3, which costs three
/// of the 19 digits.
long double definition(int n, long double x) {
  long double term = 1.0L;
  for (int i = 2; i <= n; ++i) term /= static_cast<long double>(i);
  long double sum = 0.0L;
  for (int k = 0; k < 60; ++k) {
    sum += term;
    term *= -x / (static_cast<long double>(n + 2 * k + 1) * static_cast<long double>(n + 2 * k + 2));
  }
  return sum;
}

TEST(Stumpff, EqualsItsDefiningSeries) {
  int num_checked = 0;
  for (double x = 0.0; x <= 60.0; x += x < 2.0 ? 1.0 / 64.0 : 0.5) {
    const auto c = stumpff(x);
    for (int n = 0; n < 6; ++n) {
      EXPECT_NEAR(c[static_cast<std::size_t>(n)], static_cast<double>(definition(n, x)), kValueTolerance)
          << "c_" << n << " at " << x;
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 6 * (128 + 117));
}

TEST(Stumpff, ValueAndDerivativeAreContinuousAcrossTheSwitch) {
  using Jet = ceres::Jet<double, 1>;
  const auto series = stumpff(Jet(kStumpffSeriesLimit, 0));
  const auto closed = stumpff(Jet(std::nextafter(kStumpffSeriesLimit, 2.0), 0));
  for (std::size_t n = 0; n < 6; ++n) {
    EXPECT_NEAR(series[n].a, closed[n].a, kValueTolerance) << "c_" << n;
    EXPECT_NEAR(series[n].v[0], closed[n].v[0], kDerivativeTolerance) << "c_" << n;
  }
}

TEST(Stumpff, HasADerivativeAtZero) {
  // d/dx of sum_k (-x)^k / (n + 2k)! at 0 is -1 / (n + 2)!.
  using Jet = ceres::Jet<double, 1>;
  const auto c = stumpff(Jet(0.0, 0));
  for (std::size_t n = 0; n < 6; ++n) {
    const double factorial = std::tgamma(static_cast<double>(n) + 3.0);
    EXPECT_NEAR(c[n].v[0], -1.0 / factorial, kDerivativeTolerance) << "c_" << n;
  }
}

TEST(Stumpff, PassesNaNOn) {
  for (const double value : stumpff(std::numeric_limits<double>::quiet_NaN())) EXPECT_TRUE(std::isnan(value));
}

}  // namespace
}  // namespace alidade
