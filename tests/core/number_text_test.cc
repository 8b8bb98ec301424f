// SPDX-License-Identifier: MIT
#include "alidade/core/number_text.h"

#include <gtest/gtest.h>

namespace alidade {
namespace {

TEST(PercentText, SaysAllAndNothingOnlyOfExactlyThat) {
  EXPECT_EQ(percentText(1), "100 %");
  EXPECT_EQ(percentText(0.9958), "> 99 %");
  EXPECT_EQ(percentText(0.99999), "> 99 %");
  EXPECT_EQ(percentText(0.99), "99 %");
  EXPECT_EQ(percentText(0.0149), "1 %");
  EXPECT_EQ(percentText(0.0099), "< 1 %");
  EXPECT_EQ(percentText(1e-9), "< 1 %");
  EXPECT_EQ(percentText(0), "0 %");
}

TEST(NumberText, NeedsNoExponentForWhatPeopleMeasure) {
  EXPECT_EQ(numberText("%.2g", 113.4), "110");
  EXPECT_EQ(numberText("%.2g", 0.0683), "0.068");
  EXPECT_EQ(numberText("%.3g", 4332.5), "4330");
  EXPECT_EQ(numberText("%.2g", -1234), "-1200");
  EXPECT_EQ(numberText("%.1g", 1.3e17), "1e+17");
  EXPECT_EQ(numberText("%.4f", 1234.5), "1234.5000");
}

}  // namespace
}  // namespace alidade
