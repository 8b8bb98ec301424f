// SPDX-License-Identifier: MIT
// The short form of bench/uncertainty_bench: few sets, and limits that chance alone does not reach.
#include <algorithm>

#include <gtest/gtest.h>

#include "alidade/core/parallel.h"
#include "support/choice_sweep.h"
#include "support/coverage.h"

namespace alidade {
namespace {

constexpr int kNumSets = 30;  // a model

std::vector<Judged> judgeSets(Trouble trouble, int num_sets = kNumSets) {
  std::vector<Judged> judged(2 * static_cast<std::size_t>(num_sets));
  parallelFor(judged.size(), 0, [&](std::size_t i) {
    const char* model = i % 2 == 0 ? "radtan" : "kannala_brandt";
    judged[i] = judgeSet(drawTroubledSet(model, trouble, streamSeed(3, i)), trouble);
  });
  for (const Judged& set : judged) EXPECT_TRUE(set.is_converged);
  return judged;
}

// A set's parameters share their luck: a share of 95 % of 60 sets has a standard deviation of 2.8 % at most.
void expectCovered(const std::vector<Judged>& sets, double at_least) {
  const Coverage stated = coverageOf(sets, &Judged::Parameter::stated_std);
  EXPECT_EQ(stated.count, static_cast<int>(sets.size()) / 2 * (9 + 8));
  EXPECT_GT(stated.covered, at_least);
  for (const Place place : kAllPlaces) {
    const Coverage projection = coverageOf(sets, place);
    EXPECT_EQ(projection.count, static_cast<int>(sets.size()));
    EXPECT_GT(projection.covered, at_least - 0.03);
  }
}

void expectTrueSigmas(Trouble trouble) {
  const auto sets = judgeSets(trouble);
  EXPECT_NEAR(coverageOf(sets, &Judged::Parameter::std).std, 1, 0.12);
  expectCovered(sets, 0.91);
  EXPECT_LT(coverageOf(sets, &Judged::Parameter::stated_std).covered, 0.985);
  int num_exceeded = 0;
  for (const Judged& set : sets) num_exceeded += set.is_noise_exceeded ? 1 : 0;
  EXPECT_LE(num_exceeded, 4);  // of 60, each by chance once in 100
}

TEST(Uncertainty, IsTrueUnderNoise) {
  expectTrueSigmas(Trouble::kNone);
}

// Of the larger models too, with views enough to determine their parameters.
TEST(Uncertainty, IsTrueOfLargeModels) {
  constexpr std::size_t kNumOfModel = 30;
  constexpr int kNumViews = 30;
  for (const auto& [model, num_params] : {std::pair("tilted", 18), {"fisheye624", 16}, {"ocam", 10}}) {
    std::vector<Judged> sets(kNumOfModel);
    parallelFor(sets.size(), 0, [&](std::size_t i) {
      const ChoiceSet drawn = drawChoiceSet(model, 55, i, kNumViews);
      sets[i] = judgeSet({.drawn = drawn.drawn, .views = drawn.set}, Trouble::kNone);
    });
    EXPECT_EQ(std::ranges::count_if(sets, &Judged::is_converged), static_cast<int>(kNumOfModel)) << model;
    const Coverage stated = coverageOf(sets, &Judged::Parameter::stated_std);
    EXPECT_EQ(stated.count, static_cast<int>(kNumOfModel) * num_params) << model;
    // A set's parameters share their luck.
    EXPECT_NEAR(stated.covered, 0.95, 0.04) << model;
    for (const Place place : kAllPlaces) EXPECT_GE(coverageOf(sets, place).covered, 0.83) << model;
  }
}

TEST(Uncertainty, IsTrueWithOutliers) {
  expectTrueSigmas(Trouble::kOutliers);
}

TEST(Uncertainty, AllowsForViewsThatMove) {
  const auto sets = judgeSets(Trouble::kMotion, 2 * kNumSets);
  EXPECT_LT(coverageOf(sets, &Judged::Parameter::std).covered, 0.9) << "noise alone does not explain it";
  EXPECT_GT(coverageOf(sets, &Judged::Parameter::std_by_views).covered, 0.9);
  expectCovered(sets, 0.9);
}

TEST(Uncertainty, AllowsForABoardThatIsBentButHeldFlat) {
  const auto sets = judgeSets(Trouble::kBentBoard);
  EXPECT_LT(coverageOf(sets, &Judged::Parameter::std).covered, 0.7) << "noise alone does not explain it";
  expectCovered(sets, 0.9);
  // Every parameter by itself, the focal length too, of which all views have the same error.
  constexpr int kFewestParameters = 8;
  for (const auto std : {&Judged::Parameter::std_by_views, &Judged::Parameter::stated_std}) {
    for (int i = 0; i < kFewestParameters; ++i) EXPECT_GT(coverageOf(sets, std, i).covered, 0.9) << i;
    EXPECT_NEAR(coverageOf(sets, std).std, 1, 0.12) << "and no larger than need be";
  }
}

}  // namespace
}  // namespace alidade
