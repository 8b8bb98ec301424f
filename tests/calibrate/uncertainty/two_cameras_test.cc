// SPDX-License-Identifier: MIT
#include "alidade/calibrate/uncertainty/view_evidence.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "alidade/calibrate/calibrator.h"
#include "support/choice_sweep.h"

namespace alidade {
namespace {

constexpr const char* kModels[] = {"radtan", "kannala_brandt", "double_sphere"};

// Another unit of the same lens.
DrawnCamera otherUnit(const DrawnCamera& drawn, Random& random) {
  constexpr double kFocalShare = 0.005;
  constexpr double kCentrePx = 5;
  const auto params = drawn.camera.parameters();
  std::vector<double> other(params.begin(), params.end());
  const double factor = 1 + kFocalShare * random.normal();
  other[0] *= factor;
  other[1] *= factor;
  other[2] += kCentrePx * random.normal();
  other[3] += kCentrePx * random.normal();
  DrawnCamera unit = drawn;
  unit.camera = AnyCamera::make(drawn.camera.modelId(), other);
  return unit;
}

// The names do not say which camera a view is of.
std::vector<View> mixedViews(const ChoiceSet& set, std::uint64_t seed) {
  constexpr int kNumViews = 15;
  Random random(seed);
  const DrawnCamera other = otherUnit(set.drawn, random);
  std::vector<View> views = set.set.views;
  for (View& view : drawUserViews(other, kNumViews, 0.1, random).views) views.push_back(std::move(view));
  for (std::size_t v = 0; v < views.size(); ++v) views[v].image = "view_" + std::to_string(v);
  return views;
}

TEST(TwoCameras, InOneFolderAreNamed) {
  constexpr std::size_t kNumSets = 9;
  constexpr std::size_t kNumViews = 15;
  std::size_t num_named = 0;
  std::size_t num_right = 0;
  for (std::size_t i = 0; i < kNumSets; ++i) {
    const char* model = kModels[i % std::size(kModels)];
    const ChoiceSet set = drawChoiceSet(model, 11, i, static_cast<int>(kNumViews));
    const Calibration result = calibrate(set.set.board, mixedViews(set, i), {.model = model});
    EXPECT_EQ(result.verdict(), Verdict::kNo) << model << " " << i;
    if (!hasFinding(result, "two_cameras")) continue;
    ++num_named;
    const auto& minority = result.uncertainty.two_cameras->minority;
    const auto num_first = std::count_if(minority.begin(), minority.end(), [&](std::size_t v) {
      return result.fit.views[v].source < kNumViews;
    });
    // All but a view that says little are told apart.
    if (num_first <= 1 || num_first + 1 >= std::ssize(minority)) ++num_right;
  }
  EXPECT_GE(num_named, kNumSets - 1);
  EXPECT_GE(num_right, num_named - 1);
}

TEST(TwoCameras, AreNotSeenInViewsOfOne) {
  std::size_t num_sets = 0;
  for (const char* model : kModels) {
    for (std::uint64_t number = 0; number < 6; ++number, ++num_sets) {
      const ChoiceSet set = drawChoiceSet(model, 12, number);
      const Calibration result = calibrate(set.set.board, set.set.views, {.model = model});
      EXPECT_FALSE(result.uncertainty.two_cameras) << model << " " << number;
    }
  }
  EXPECT_EQ(num_sets, 18U);
}

// Each view is by a lens of its own, as if it shook: among 12 parameters some line divides 15 views.
TEST(TwoCameras, AreNotSeenInViewsThatAllDiffer) {
  std::size_t num_sets = 0;
  for (std::uint64_t number = 0; number < 8; ++number, ++num_sets) {
    constexpr int kNumViews = 15;
    constexpr double kCentrePx = 0.5;
    Random random(100 + number);
    const ChoiceSet set = drawChoiceSet("radtan", 14, number, kNumViews);
    const auto params = set.drawn.camera.parameters();
    std::vector<View> views;
    for (int v = 0; v < kNumViews; ++v) {
      std::vector<double> moved(params.begin(), params.end());
      moved[2] += kCentrePx * random.normal();
      moved[3] += kCentrePx * random.normal();
      DrawnCamera shaken = set.drawn;
      shaken.camera = AnyCamera::make("radtan", moved);
      views.push_back(drawUserViews(shaken, 1, 0.02, random).views.at(0));
      views.back().image = "view_" + std::to_string(v);
    }
    const Calibration result = calibrate(set.set.board, views, {.model = "rational"});
    EXPECT_FALSE(result.uncertainty.two_cameras) << number;
  }
  EXPECT_EQ(num_sets, 8U);
}

TEST(TwoCameras, AreToldApartByTheNamesOfTheirImages) {
  const ChoiceSet set = drawChoiceSet("radtan", 13, 0, 12);
  Random random(5);
  DrawnCamera other = set.drawn;
  const auto params = set.drawn.camera.parameters();
  std::vector<double> moved(params.begin(), params.end());
  moved[2] += 4;
  other.camera = AnyCamera::make("radtan", moved);
  std::vector<View> views = set.set.views;
  for (View& view : views) view.image = "left/" + view.image;
  for (View& view : drawUserViews(other, 12, 0.1, random).views) {
    view.image = "right/" + view.image;
    views.push_back(std::move(view));
  }
  const Calibration named = calibrate(set.set.board, views, {.model = "radtan"});
  ASSERT_TRUE(named.uncertainty.two_cameras);
  EXPECT_EQ(named.uncertainty.two_cameras->minority.size(), 12U);
  EXPECT_NEAR(std::abs(named.uncertainty.two_cameras->params_step[2]), 4, 1);
}

}  // namespace
}  // namespace alidade
