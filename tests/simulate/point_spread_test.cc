// SPDX-License-Identifier: MIT
#include "alidade/simulate/render.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace alidade {
namespace {

TEST(PointSpreadShare, IsTheIntegralOfTheGaussianOverThePixel) {
  int num_checked = 0;
  for (const double blur : {0.2, 0.8, 2.0}) {
    for (double x = -4; x <= 4; x += 0.37) {
      // Midpoint rule over the pixel's width; its error is of order 1 / (24 n^2).
      constexpr int kNumSteps = 2000;
      double mean = 0;
      for (int i = 0; i < kNumSteps; ++i) {
        const double u = (i + 0.5) / kNumSteps - 0.5;
        mean += 0.5 * std::erfc(-(x - u) / (blur * std::numbers::sqrt2)) / kNumSteps;
      }
      EXPECT_NEAR(pointSpreadShare(x, blur), mean, 1e-6);
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 66);
  EXPECT_DOUBLE_EQ(pointSpreadShare(0.25, 0), 0.75);
  EXPECT_DOUBLE_EQ(pointSpreadShare(-3, 0), 0);
}

TEST(PointSpread, IsSymmetricAndEvenAlongEachAxis) {
  constexpr double kBlur = 0.8;
  // Odd and even counts and generators, and counts to round up.
  for (const int min_samples : {1, 2, 3, 5, 8, 13, 144, 233, 300, 377}) {
    const PointSpread spread = makePointSpread(kBlur, min_samples);
    const std::size_t count = spread.size();
    ASSERT_GE(count, static_cast<std::size_t>(min_samples));
    std::vector<double> sorted = spread.y;
    std::sort(sorted.begin(), sorted.end());
    for (std::size_t i = 0; i < count; ++i) {
      EXPECT_EQ(spread.x[i], -spread.x[count - 1 - i]);
      EXPECT_EQ(spread.y[i], -spread.y[count - 1 - i]);
      EXPECT_EQ(sorted[i], spread.x[i]);
      EXPECT_LE(std::hypot(spread.x[i], spread.y[i]), spread.radius_px);
      EXPECT_NEAR(pointSpreadShare(spread.x[i], kBlur), (static_cast<double>(i) + 0.5) / count, 1e-12);
    }
  }
  EXPECT_EQ(makePointSpread(kBlur, 300).size(), 377U);
}

TEST(PointSpread, HasTheMomentsOfPixelAndBlur) {
  constexpr double kBlur = 0.8;
  const PointSpread spread = makePointSpread(kBlur, 1597);
  double xx = 0;
  double xy = 0;
  for (std::size_t i = 0; i < spread.size(); ++i) {
    xx += spread.x[i] * spread.x[i] / spread.size();
    xy += spread.x[i] * spread.y[i] / spread.size();
  }
  // A quantile in the middle of each share takes a little from the tails' variance.
  EXPECT_NEAR(xx, kBlur * kBlur + 1.0 / 12, 2e-3);
  EXPECT_NEAR(xy, 0, 2e-3);
}

}  // namespace
}  // namespace alidade
