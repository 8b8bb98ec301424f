// SPDX-License-Identifier: MIT
#include "alidade/core/random.h"

#include <gtest/gtest.h>

#include <cmath>

namespace alidade {
namespace {

constexpr int kNumDraws = 200000;

TEST(Random, SameSeedSameNumbers) {
  Random a(7);
  Random b(7);
  for (int i = 0; i < 1000; ++i) ASSERT_EQ(a.normal(), b.normal());
}

TEST(Random, NormalHasTheMomentsOfAStandardNormal) {
  Random random(1);
  double sum = 0;
  double sum2 = 0;
  double sum4 = 0;
  for (int i = 0; i < kNumDraws; ++i) {
    const double x = random.normal();
    sum += x;
    sum2 += x * x;
    sum4 += x * x * x * x;
  }
  // Five standard errors of each mean.
  const double standard_error = 1.0 / std::sqrt(static_cast<double>(kNumDraws));
  EXPECT_NEAR(sum / kNumDraws, 0.0, 5 * standard_error);
  EXPECT_NEAR(sum2 / kNumDraws, 1.0, 5 * std::sqrt(2.0) * standard_error);
  EXPECT_NEAR(sum4 / kNumDraws, 3.0, 5 * std::sqrt(96.0) * standard_error);
}

TEST(Random, UniformStaysInItsRange) {
  Random random(2);
  double sum = 0;
  for (int i = 0; i < kNumDraws; ++i) {
    const double x = random.uniform(-2.0, 4.0);
    ASSERT_GE(x, -2.0);
    ASSERT_LT(x, 4.0);
    sum += x;
  }
  EXPECT_NEAR(sum / kNumDraws, 1.0, 5 * 6.0 / std::sqrt(12.0 * kNumDraws));
}

TEST(StreamSeed, NeighbouringStreamsDiffer) {
  Random a(streamSeed(1, 0));
  Random b(streamSeed(1, 1));
  int num_equal = 0;
  for (int i = 0; i < 1000; ++i) num_equal += a.index(1000) == b.index(1000) ? 1 : 0;
  EXPECT_LT(num_equal, 15);
}

}  // namespace
}  // namespace alidade
