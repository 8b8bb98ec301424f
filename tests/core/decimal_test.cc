// SPDX-License-Identifier: MIT
#include "alidade/core/decimal.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "alidade/core/random.h"
#include "alidade/core/text.h"

namespace alidade {
namespace {

std::string decimalText(double value) {
  std::array<char, kMaxDecimalChars> buffer{};
  return {buffer.data(), writeDecimal(buffer.data(), value)};
}

// Counts numbers whose text differs from that of std::to_chars.
class Comparison {
 public:
  void add(double value) {
    ++num_compared;
    const std::string expected = exactText(value);
    const std::string found = decimalText(value);
    if (found != expected && num_different++ < 5) ADD_FAILURE() << found << " instead of " << expected;
  }
  // The number, its negative, and their nearest neighbours.
  void addAround(double value, int reach) {
    double above = value;
    double below = value;
    for (int i = 0; i < reach; ++i) {
      for (const double x : {above, -above, below, -below}) add(x);
      above = std::nextafter(above, std::numeric_limits<double>::infinity());
      below = std::nextafter(below, 0.0);
    }
  }
  std::size_t num_compared = 0;
  std::size_t num_different = 0;
};

TEST(WriteDecimal, IsTheShortestTextOfRandomNumbers) {
  Comparison comparison;
  Random random(1);
  constexpr int kCount = 300'000;
  for (int i = 0; i < kCount; ++i) {
    // Of all sizes in the range with a way of its own and somewhat beyond.
    comparison.add(random.uniform(-1, 1) * std::pow(10.0, random.uniform(-5, 7)));
    // Few digits, and few bits, among which are the numbers halfway between two decimals.
    comparison.add(static_cast<double>(random.index(1'000'000'000)) /
                   std::pow(10.0, static_cast<double>(random.index(12))));
    comparison.add(std::ldexp(static_cast<double>(random.index(std::uint64_t{1} << 30U)),
                              -static_cast<int>(random.index(45))));
    // Any bits at all.
    comparison.add(std::bit_cast<double>(random.index(0x7ff0'0000'0000'0000U)));
  }
  EXPECT_EQ(comparison.num_compared, 4u * kCount);
  EXPECT_EQ(comparison.num_different, 0u);
}

TEST(WriteDecimal, IsTheShortestTextAroundPowers) {
  Comparison comparison;
  constexpr int kReach = 50;
  for (int i = -60; i <= 60; ++i) comparison.addAround(std::ldexp(1.0, i), kReach);
  for (int i = -20; i <= 20; ++i) comparison.addAround(std::pow(10.0, i), kReach);
  for (int i = 0; i <= 2000; ++i) comparison.addAround(i, 2);
  for (const double x :
       {0.0, -0.0, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN(),
        std::numeric_limits<double>::max(), std::numeric_limits<double>::denorm_min()})
    comparison.add(x);
  EXPECT_EQ(comparison.num_compared, 4u * (kReach * (121 + 41) + 2 * 2001) + 6);
  EXPECT_EQ(comparison.num_different, 0u);
}

TEST(WriteDecimal, WritesWhatPeopleExpect) {
  EXPECT_EQ(decimalText(0.1), "0.1");
  EXPECT_EQ(decimalText(-375.5), "-375.5");
  EXPECT_EQ(decimalText(2.9999999999999996), "2.9999999999999996");
  EXPECT_EQ(decimalText(65536.00024414062), "65536.00024414062");
  EXPECT_EQ(decimalText(640), "640");
  EXPECT_EQ(decimalText(1e-5), "1e-05");
}

}  // namespace
}  // namespace alidade
