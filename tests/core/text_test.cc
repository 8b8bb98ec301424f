// SPDX-License-Identifier: MIT
#include "alidade/core/text.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <limits>

namespace alidade {
namespace {

TEST(ParseDouble, ReadsWholeNumbersOnly) {
  EXPECT_EQ(parseDouble("1.5e-3"), 1.5e-3);
  EXPECT_EQ(parseDouble("+2"), 2.0);
  EXPECT_EQ(parseDouble("-.5"), -0.5);
  for (const char* bad : {"", " 1", "1 ", "1,5", "1.5x", "0x10", "--1", "+", "+-1", "++1"}) {
    EXPECT_FALSE(parseDouble(bad)) << '"' << bad << '"';
  }
}

TEST(ExactText, ReadsBackUnchanged) {
  for (const double x : {0.1, 1.0 / 3.0, 1e300, -5e-324, 123456789.125})
    EXPECT_EQ(parseDouble(exactText(x)), x);
}

TEST(NearestName, FindsSlipsAndRefusesStrangers) {
  const std::vector<std::string> names = {"pinhole", "radtan", "image_size"};
  EXPECT_EQ(nearestName("radtn", names), "radtan");
  EXPECT_EQ(nearestName("imagesize", names), "image_size");
  EXPECT_EQ(nearestName("kannala", names), std::nullopt);
}

TEST(NaturalLess, SortsNumbersByValue) {
  std::vector<std::string> names = {"img10", "img2", "img02", "img1", "img", "a10b2", "a10b10"};
  std::sort(names.begin(), names.end(), [](const auto& a, const auto& b) { return naturalLess(a, b); });
  EXPECT_THAT(names, testing::ElementsAre("a10b2", "a10b10", "img", "img1", "img02", "img2", "img10"));
}

TEST(Split, KeepsEmptyFields) {
  EXPECT_THAT(split("a,,b,", ','), testing::ElementsAre("a", "", "b", ""));
}

}  // namespace
}  // namespace alidade
