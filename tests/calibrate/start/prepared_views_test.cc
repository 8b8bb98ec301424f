// SPDX-License-Identifier: MIT
#include "alidade/calibrate/start/prepared_views.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "alidade/calibrate/calibrator.h"
#include "alidade/core/error.h"
#include "support/image_sizes.h"
#include "support/simulated_set.h"

namespace alidade {
namespace {

constexpr int kNumCopies = 50;

SimulatedSet baseSet() {
  const std::vector<double> truth = {1003, 1001, 645, 475, -0.28, 0.08, 8e-4, -4e-4, -0.01};
  return simulateSet(AnyCamera::make("radtan", truth), kQuadVga, 20, 0.1, 4);
}

// Adds copies of a view whose corners differ from it by noise.
void addCopies(std::vector<View>& views, std::size_t of, double noise_px) {
  Random random(5);
  for (int i = 0; i < kNumCopies; ++i) {
    View copy = views[of];
    copy.image = "w_copy_" + std::to_string(i);
    for (Corner& corner : copy.corners)
      corner.pixel += noise_px * Eigen::Vector2d(random.normal(), random.normal());
    views.push_back(std::move(copy));
  }
}

// By how much, in sigmas, and by what factor the largest change of a parameter and of a sigma is.
struct Change {
  double move_sigmas = 0;
  double std_ratio = 1;
};

Change changeBetween(const Calibration& before, const Calibration& after) {
  Change change;
  for (int i = 0; i < 9; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double move = onlyCamera(after.fit).params[k] - onlyCamera(before.fit).params[k];
    change.move_sigmas =
        std::max(change.move_sigmas, std::abs(move) / before.uncertainty.parameterStdByNoise(i));
    const double ratio = after.uncertainty.parameterStdByNoise(i) / before.uncertainty.parameterStdByNoise(i);
    change.std_ratio = std::max({change.std_ratio, ratio, 1 / ratio});
  }
  return change;
}

bool hasFinding(const Calibration& result, const std::string& id) {
  return std::any_of(result.diagnoses.begin(), result.diagnoses.end(),
                     [&](const Diagnosis& finding) { return finding.id == id; });
}

TEST(RepeatedViews, FiftyCopiesChangeNothing) {
  const SimulatedSet set = baseSet();
  const Calibration alone = calibrate(set.board, set.views, {.model = "radtan"});
  EXPECT_TRUE(alone.dropped.repeated.empty());
  // Exact copies; noise of the axes whose length is below 0.25 px.
  for (const double noise_px : {0.0, 0.05, 0.15}) {
    std::vector<View> views = set.views;
    addCopies(views, 3, noise_px);
    const Calibration result = calibrate(set.board, views, {.model = "radtan"});
    EXPECT_EQ(result.fit.views.size(), 20U);
    EXPECT_EQ(result.dropped.repeated.size(), static_cast<std::size_t>(kNumCopies));
    EXPECT_TRUE(hasFinding(result, "repeated_views"));
    EXPECT_TRUE(result.dropped.views.empty());
    const Change change = changeBetween(alone, result);
    EXPECT_LT(change.move_sigmas, 0.1) << noise_px;
    EXPECT_LT(change.std_ratio, 1.1) << noise_px;
  }
}

TEST(RepeatedViews, ASeriesFromATripodIsOneView) {
  SimulatedSet set = baseSet();
  const Calibration alone = calibrate(set.board, set.views, {.model = "radtan"});
  Random random(6);
  for (int i = 0; i < kNumCopies; ++i) {
    View view = exactView(set.camera, kQuadVga, set.board, set.poses[7], "w_series_" + std::to_string(i));
    addCornerNoise(view, 0.1, random);
    set.views.push_back(std::move(view));
  }
  const Calibration result = calibrate(set.board, set.views, {.model = "radtan"});
  EXPECT_EQ(result.fit.views.size(), 20U);
  EXPECT_LT(changeBetween(alone, result).std_ratio, 1.1);
}

TEST(RepeatedViews, AMoveOfAHalfPixelIsAnotherView) {
  SimulatedSet set = baseSet();
  View moved = exactView(set.camera, kQuadVga, set.board, set.poses[7], "w_moved");
  for (Corner& corner : moved.corners) corner.pixel.x() += 0.5;
  set.views.push_back(moved);
  EXPECT_TRUE(calibrate(set.board, set.views, {.model = "radtan"}).dropped.repeated.empty());
}

TEST(RepeatedViews, DoNotDependOnTheOrderOfTheFiles) {
  const SimulatedSet set = baseSet();
  std::vector<View> views = set.views;
  addCopies(views, 3, 0.1);
  const Calibration result = calibrate(set.board, views, {.model = "radtan"});
  std::reverse(views.begin(), views.end());
  const Calibration reversed = calibrate(set.board, views, {.model = "radtan"});
  for (std::size_t k = 0; k < 9; ++k)
    EXPECT_EQ(onlyCamera(result.fit).params[k], onlyCamera(reversed.fit).params[k]);
  ASSERT_EQ(result.dropped.repeated.size(), reversed.dropped.repeated.size());
  EXPECT_EQ(result.dropped.repeated.front().image, reversed.dropped.repeated.front().image);
}

TEST(RepeatedViews, OneBlunderInACopyDoesNotCount) {
  const SimulatedSet set = baseSet();
  std::vector<View> views = set.views;
  addCopies(views, 3, 0.02);
  views.back().corners[10].pixel.x() += 300;
  views.back().corners.erase(views.back().corners.begin());
  const Calibration result = calibrate(set.board, views, {.model = "radtan"});
  EXPECT_EQ(result.fit.views.size(), 20U);
  EXPECT_TRUE(result.dropped.outliers.empty());
}

TEST(RepeatedViews, TooFewPlacesAreAnError) {
  SimulatedSet set = baseSet();
  set.views.resize(2);
  addCopies(set.views, 0, 0.1);
  EXPECT_THROW(static_cast<void>(calibrate(set.board, set.views, {.model = "radtan"})), Error);
}

}  // namespace
}  // namespace alidade
