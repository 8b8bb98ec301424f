// SPDX-License-Identifier: MIT
#include "alidade/adjust/noise/cross_validation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>

namespace alidade {
namespace {

HeldOutScore scoreWith(std::vector<double> of_view) {
  HeldOutScore score{.of_view = std::move(of_view), .sum = 0};
  score.sum = std::accumulate(score.of_view.begin(), score.of_view.end(), 0.0);
  return score;
}

TEST(HeldOutExcess, IsTheDifferenceOfRmsWithItsStandardError) {
  const HeldOutScore lean = scoreWith({110, 130, 120, 125});
  const HeldOutScore rich = scoreWith({100, 110, 95, 95});
  const HeldOutExcess excess = excessOf(lean, rich);
  EXPECT_NEAR(excess.share, std::sqrt(485.0 / 400) - 1, 1e-12);
  // Differences 10, 20, 25, 30: mean 21.25, sum of squares about it 218.75.
  const double std = std::sqrt(4.0 / 3 * 218.75);
  EXPECT_NEAR(excess.std, std / (2 * 400) / std::sqrt(485.0 / 400), 1e-12);
  EXPECT_TRUE(excess.is_significant);
  EXPECT_TRUE(excess.isWorth(20));
  EXPECT_FALSE(excess.isWorth(21));
  EXPECT_FALSE(excessOf(rich, lean).isWorth(0));
  EXPECT_FALSE(excessOf(rich, rich).isWorth(0));
}

// Differences of equal size but one: their mean over its standard error is the statistic that Student's
// tables list.
TEST(HeldOutExcess, IsSignificantFromStudentsLimitOn) {
  const struct {
    int freedom;
    double limit;  // one-sided, 5 %, from tables
  } cases[] = {{2, 2.920}, {4, 2.132}, {9, 1.833}, {19, 1.729}, {99, 1.660}};
  int num_checked = 0;
  for (const auto& c : cases) {
    const int n = c.freedom + 1;
    for (const double factor : {0.9, 1.1}) {
      // Half a step up and down in turn about a mean that gives the statistic; the last one makes n even.
      std::vector<double> differences;
      for (int i = 0; i < n; ++i) differences.push_back(i % 2 == 0 ? 1.0 : -1.0);
      if (n % 2 == 1) differences.back() = 0;
      double scatter = 0;
      for (const double d : differences) scatter += d * d;
      const double mean = factor * c.limit * std::sqrt(scatter / c.freedom / n);
      std::vector<double> lean;
      for (const double d : differences) lean.push_back(1000 + mean + d);
      const auto excess =
          excessOf(scoreWith(lean), scoreWith(std::vector<double>(static_cast<std::size_t>(n), 1000.0)));
      EXPECT_EQ(excess.is_significant, factor > 1) << c.freedom;
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 10);
}

// Every view is four times as far off, and one of them by far the most: its sum says more about it than about
// the model, the factor does not.
TEST(HeldOutExcess, IsSignificantByTheFactorWhereOneViewHidesTheRest) {
  const HeldOutScore rich = scoreWith({10, 9, 12, 2000});
  const HeldOutScore lean = scoreWith({170, 140, 200, 33000});
  const HeldOutExcess excess = excessOf(lean, rich);
  EXPECT_GT(excess.share, 3);
  EXPECT_LT(excess.share, 1.7 * excess.std) << "the sums alone prove nothing";
  EXPECT_TRUE(excess.is_significant);
  EXPECT_TRUE(excess.isWorth(10));
  EXPECT_FALSE(excessOf(rich, lean).is_significant);
  EXPECT_FALSE(excessOf(scoreWith({170, 5, 6, 33000}), rich).is_significant) << "only some are worse";
}

// All views are better by 1 % but one, which is better by 20 % and by far the largest: what is proven is 0.5
// % of the RMS and not its 9 %.
TEST(HeldOutExcess, IsWorthNoMoreThanTheFactorsProve) {
  std::vector<double> rich(12, 100.0);
  std::vector<double> lean(12, 101.0);
  for (std::size_t i = 0; i < lean.size(); ++i) lean[i] += i % 2 == 0 ? 0.1 : -0.1;
  rich[0] = 1e5;
  lean[0] = 1.2e5;
  const HeldOutExcess excess = excessOf(scoreWith(lean), scoreWith(rich));
  EXPECT_GT(excess.share, 0.08);
  EXPECT_LT(excess.share, 1.7 * excess.std) << "the sums alone prove nothing";
  EXPECT_LT(excess.proven_share, 0.02);
  EXPECT_FALSE(excess.isWorth(4));
}

TEST(HeldOutExcess, NeedsMuchOfTwoViews) {
  EXPECT_FALSE(excessOf(scoreWith({110, 150}), scoreWith({100, 100})).is_significant);
  EXPECT_TRUE(excessOf(scoreWith({148, 150}), scoreWith({100, 100})).is_significant);
}

TEST(HeldOutExcess, TakesNoViewWithoutErrorsForAnEqualOne) {
  const HeldOutExcess all = excessOf(scoreWith({110, 130, 120}), scoreWith({100, 110, 95}));
  const HeldOutExcess with_gap = excessOf(scoreWith({110, 0, 130, 120}), scoreWith({100, 0, 110, 95}));
  EXPECT_EQ(all.share, with_gap.share);
  EXPECT_EQ(all.std, with_gap.std);
  EXPECT_EQ(all.is_significant, with_gap.is_significant);
}

TEST(HeldOutScore, CountsCornersThatAreNotSeenAsFarOff) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const HuberLoss loss{.threshold_px = 0.3};
  Fit fit{.loss = loss};
  fit.views.push_back({.corners = {{.p_board = {0, 0, 0}, .pixel = {0, 0}, .weight = 2},
                                   {.p_board = {0, 0, 0}, .pixel = {0, 0}}}});
  fit.views.emplace_back();
  const HeldOutErrors errors{.num_folds = 2, .px = {{{0.1, 0}, {kNan, kNan}}, {}}};
  const HeldOutScore score = scoreOf(errors, fit);
  EXPECT_NEAR(score.of_view[0], 2 * 0.01 + loss.rho(9) + noiseFloor(2), 1e-12);
  EXPECT_EQ(score.of_view[1], 0);
  EXPECT_EQ(score.sum, score.of_view[0]);
}

}  // namespace
}  // namespace alidade
