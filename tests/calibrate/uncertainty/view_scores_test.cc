// SPDX-License-Identifier: MIT
#include "alidade/calibrate/uncertainty/view_scores.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "alidade/calibrate/calibrator.h"
#include "support/spoiled_set.h"

namespace alidade {
namespace {

constexpr const char* kModels[] = {"radtan", "kannala_brandt"};

Calibration run(const SimulatedSet& set) {
  return calibrate(set.board, set.views, {.model = std::string(set.camera.modelId())});
}

std::vector<std::string> named(const Calibration& result, std::string_view id) {
  std::vector<std::string> images;
  for (const Diagnosis& finding : result.diagnoses) {
    if (finding.id == id) images.push_back(finding.message().substr(0, finding.message().find(':')));
  }
  return images;
}

// The most that any function of the parameters moves by is the length of the step in their own metric.
double moveSigmas(const Calibration& with, const Calibration& without) {
  const auto a = onlyCamera(with.fit).params;
  const auto b = onlyCamera(without.fit).params;
  Eigen::VectorXd step(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) step(static_cast<Eigen::Index>(i)) = b[i] - a[i];
  return std::sqrt(step.dot(with.uncertainty.covariance->view().ldlt().solve(step)));
}

TEST(ViewInfluence, IsWhatLeavingTheViewOutDoes) {
  int num_checked = 0;
  for (const char* model : kModels) {
    const SimulatedSet set = cleanSet(model, 12, 3);
    const Calibration all = run(set);
    for (std::size_t v = 0; v < all.fit.views.size(); v += 2) {
      std::vector<View> views = set.views;
      std::erase_if(views, [&](const View& view) { return view.image == all.fit.views[v].image; });
      const double truth = moveSigmas(all, calibrate(set.board, views, {.model = model}));
      // Of first order, and the loss weighs some corners anew.
      EXPECT_NEAR(all.uncertainty.influences[v].move_sigmas, truth, 0.15 * truth + 0.1)
          << all.fit.views[v].image;
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 12);
}

TEST(ViewInfluence, AFaintlyBentViewIsNamedAndCleanOnesAreNot) {
  int num_found = 0;
  int num_sets = 0;
  for (const char* model : kModels) {
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
      SimulatedSet set = cleanSet(model, 15, seed);
      EXPECT_THAT(named(run(set), "influential_view"), testing::IsEmpty());
      const auto bad = spoilViews(set, Spoiler::kFaint, 1, seed);
      const Calibration result = run(set);
      auto images = named(result, "influential_view");
      for (const ExcludedView& view : result.dropped.views) images.push_back(view.image);
      for (const std::string& image : images) EXPECT_EQ(image, bad.front());
      if (!images.empty()) ++num_found;
      ++num_sets;
    }
  }
  EXPECT_EQ(num_sets, 16);
  EXPECT_GE(num_found, 14);
}

TEST(BoardStretch, IsFoundWithItsSigma) {
  int num_checked = 0;
  for (const char* model : kModels) {
    for (const double stretch : {0.005, -0.005}) {
      const Calibration result = run(stretchedSet(model, 25, 1 + stretch, 11));
      ASSERT_FALSE(result.uncertainty.common_errors.empty());
      const CommonError& found = result.uncertainty.common_errors.front();
      ASSERT_EQ(found.cause, CommonCause::kStretch);
      // Of first order: a hundredth of the stretch is left.
      EXPECT_NEAR(found.value, stretch, 4 * found.sigma);
      EXPECT_LT(found.sigma, 5e-4);
      EXPECT_EQ(named(result, "board_not_square").size(), 1U);
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 4);
}

TEST(BoardStretch, OfSquareBoardsIsWithinItsSigma) {
  double sum = 0;
  int num_sets = 0;
  for (const char* model : kModels) {
    for (std::uint64_t seed = 1; seed <= 15; ++seed) {
      const Calibration result = run(cleanSet(model, 12, 100 + seed));
      ASSERT_FALSE(result.uncertainty.common_errors.empty());
      const CommonError& found = result.uncertainty.common_errors.front();
      ASSERT_EQ(found.cause, CommonCause::kStretch);
      EXPECT_TRUE(named(result, "board_not_square").empty());
      const double z = found.value / found.sigma;
      sum += z * z;
      ++num_sets;
    }
  }
  EXPECT_EQ(num_sets, 30);
  // Chi-square of 30: 1 in 1000 outside. The larger of two sigmas makes it a little small.
  EXPECT_GT(sum / num_sets, 0.38);
  EXPECT_LT(sum / num_sets, 1.99);
}

TEST(BoardStretch, CannotBeToldFromFxByViewsThatFaceTheBoard) {
  SimulatedSet set = simulateSet(spoiledCamera("radtan"), kSpoiledSize, 10, 0.1, 12,
                                 {.max_tilt_deg = 0, .max_roll_deg = 0}, kSpoiledBoard);
  const Calibration result = run(set);
  EXPECT_TRUE(named(result, "board_not_square").empty());
}

}  // namespace
}  // namespace alidade
