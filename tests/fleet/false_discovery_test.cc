// SPDX-License-Identifier: MIT
#include "alidade/fleet/false_discovery.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include <gtest/gtest.h>

#include "alidade/core/random.h"

namespace alidade {
namespace {

// The example of the paper: 15 comparisons of two treatments, four of which are positive at 5 %.
TEST(FalseDiscovery, GivesTheAnswersOfItsPaper) {
  const std::vector<double> p = {0.0001, 0.0004, 0.0019, 0.0095, 0.0201, 0.0278, 0.0298, 0.0344,
                                 0.0459, 0.3240, 0.4262, 0.5719, 0.6528, 0.7590, 1.0000};
  const std::vector<bool> positive = falseDiscoveryTest(p, 0.05);
  EXPECT_EQ(std::ranges::count(positive, true), 4);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_TRUE(positive[i]) << i;
}

TEST(FalseDiscovery, KeepsTheOrderAndLeavesOutWhatIsUnknown) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(falseDiscoveryTest(std::vector<double>{0.9, nan, 1e-9, 0.5}, 0.01),
            (std::vector<bool>{false, false, true, false}));
  EXPECT_TRUE(falseDiscoveryTest(std::vector<double>{}, 0.01).empty());
}

TEST(FalseDiscovery, AccusesNobodyInNinetyNineOfHundredFleetsWithoutDeviants) {
  constexpr int kFleets = 4000;
  Random random(5);
  int num_accused = 0;
  for (int f = 0; f < kFleets; ++f) {
    std::vector<double> p(50);
    for (double& value : p) value = random.uniform();
    num_accused += std::ranges::count(falseDiscoveryTest(p, 0.01), true) > 0 ? 1 : 0;
  }
  EXPECT_GT(num_accused, 15);  // 40 +- 6.3
  EXPECT_LT(num_accused, 65);
}

TEST(ShareAbove, IsThatOfTheNormalDistribution) {
  EXPECT_NEAR(shareAbove(0), 0.5, 1e-15);
  EXPECT_NEAR(shareAbove(1.959963984540054), 0.025, 1e-12);
  EXPECT_EQ(shareAbove(std::numeric_limits<double>::infinity()), 0);
  EXPECT_NEAR(shareAbove(8) / 6.220960574271786e-16, 1, 1e-9);
}

}  // namespace
}  // namespace alidade
