// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>

#include <algorithm>

#include "alidade/adjust/board/errors.h"
#include "alidade/calibrate/calibrator.h"
#include "support/image_sizes.h"
#include "support/simulated_set.h"

namespace alidade {
namespace {

const std::vector<double> kTruth = {1003, 1001, 645, 475, -0.28, 0.08, 8e-4, -4e-4, -0.01};

SimulatedSet cleanSet(int num_views, std::uint64_t seed) {
  return simulateSet(AnyCamera::make("radtan", kTruth), kQuadVga, num_views, 0.1, seed);
}

void expectTruth(const Calibration& result) {
  for (std::size_t i = 0; i < kTruth.size(); ++i) {
    EXPECT_NEAR(onlyCamera(result.fit).params[i], kTruth[i],
                4 * result.uncertainty.parameterStdByNoise(static_cast<int>(i)))
        << result.camera().parameterNames()[i];
  }
}

TEST(Outliers, AreNamedAndLeaveTheResultAlone) {
  SimulatedSet set = cleanSet(15, 1);
  Random random(2);
  std::vector<std::pair<std::string, int>> moved;
  for (View& view : set.views) {
    for (Corner& corner : view.corners) {
      if (random.uniform() > 0.05) continue;
      corner.pixel += Eigen::Vector2d(random.uniform() < 0.5 ? 10 : -10, random.uniform() < 0.5 ? 10 : -10);
      moved.emplace_back(view.image, corner.id);
    }
  }
  ASSERT_GT(moved.size(), 30U);
  const Calibration result = calibrate(set.board, set.views, {.model = "radtan"});
  EXPECT_TRUE(result.isUsable());
  expectTruth(result);
  std::vector<std::pair<std::string, int>> named;
  for (const Outlier& outlier : result.dropped.outliers) named.emplace_back(outlier.image, outlier.corner_id);
  EXPECT_THAT(named, testing::UnorderedElementsAreArray(moved));
  EXPECT_LT(rms(result.fit), 0.16);
  EXPECT_EQ(numCorners(result.fit) + static_cast<int>(result.dropped.outliers.size()), 15 * 54);
}

TEST(Outliers, CleanSetsHaveNone) {
  int num_sets = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    const SimulatedSet set = cleanSet(12, seed);
    const Calibration result = calibrate(set.board, set.views, {.model = "radtan"});
    EXPECT_TRUE(result.dropped.outliers.empty());
    EXPECT_TRUE(result.dropped.views.empty());
    ++num_sets;
  }
  EXPECT_EQ(num_sets, 30);
}

TEST(Outliers, AForeignViewIsLeftOutByName) {
  SimulatedSet set = cleanSet(15, 3);
  // The same corners under ids running the other way along the rows: a mirrored board, which no pose
  // explains.
  View& foreign = set.views[7];
  std::vector<Eigen::Vector2d> pixels;
  for (const Corner& corner : foreign.corners) pixels.push_back(corner.pixel);
  for (Corner& corner : foreign.corners) {
    const int mirrored = corner.id / 9 * 9 + 8 - corner.id % 9;
    corner.pixel = pixels[static_cast<std::size_t>(mirrored)] + Eigen::Vector2d(0, 3.0 * (corner.id % 5));
  }
  const Calibration result = calibrate(set.board, set.views, {.model = "radtan"});
  ASSERT_EQ(result.dropped.views.size(), 1U);
  EXPECT_EQ(result.dropped.views[0].image, foreign.image);
  EXPECT_EQ(result.fit.views.size(), 14U);
  const bool is_told = std::any_of(result.diagnoses.begin(), result.diagnoses.end(),
                                   [](const Diagnosis& f) { return f.id == "view_left_out"; });
  EXPECT_TRUE(is_told);
  expectTruth(result);
}

}  // namespace
}  // namespace alidade
