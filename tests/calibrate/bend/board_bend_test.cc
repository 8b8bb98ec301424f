// SPDX-License-Identifier: MIT
#include "alidade/calibrate/bend/shape_fit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "alidade/calibrate/calibrator.h"
#include "alidade/core/parallel.h"
#include "support/image_sizes.h"
#include "support/simulated_set.h"

namespace alidade {
namespace {

constexpr Checkerboard kBoard{.columns = 11, .rows = 8, .square_m = 0.05};  // half a metre wide
constexpr int kNumSets = 30;

// A board that bends by itself in each view, as cardboard in a hand does, about a shape of its own.
Calibration calibrated(double common_m, double scatter_m, int num_views, std::uint64_t seed) {
  const AnyCamera camera =
      AnyCamera::make("radtan", std::vector<double>{900, 902, 640, 478, -0.25, 0.08, 4e-4, -3e-4, 0});
  SimulatedSet set = simulateSet(camera, kQuadVga, num_views, 0, seed, {}, kBoard);
  Random random(seed + 1000);
  for (std::size_t v = 0; v < set.views.size(); ++v) {
    const BoardShape shape{.bend_x_m = common_m + scatter_m * random.normal(),
                           .bend_y_m = scatter_m * random.normal()};
    for (Corner& corner : set.views[v].corners) {
      const Projection projection =
          camera.project(set.poses[v] * onBentBoard(kBoard, shape, kBoard.corner(corner.id)));
      EXPECT_TRUE(projection.ok());
      corner.pixel = projection.pixel + 0.1 * Eigen::Vector2d(random.normal(), random.normal());
    }
  }
  return calibrate(kBoard, set.views, {.model = "radtan"});
}

struct Counts {
  int num_by_noise = 0;
  int num_by_views = 0;
  int num_estimated = 0;
  int num_within_2_sigma = 0;  // of those, along x
};

Counts countBends(double common_m, double scatter_m, int num_views) {
  std::vector<Calibration> results(kNumSets);
  parallelFor(results.size(), 0, [&](std::size_t i) {
    results[i] = calibrated(common_m, scatter_m, num_views, streamSeed(5, i));
  });
  Counts counts;
  for (const Calibration& result : results) {
    const ShapeReport& shape = result.choice.shapes.front();
    const bool is_estimated = isShapeEstimated(result.fit);
    EXPECT_TRUE(shape.by_views);
    counts.num_by_noise += shape.f > kBendF ? 1 : 0;
    counts.num_by_views += shape.by_views && shape.by_views->chance < 0.05 ? 1 : 0;
    counts.num_estimated += is_estimated ? 1 : 0;
    if (is_estimated && std::abs(onlyBoard(result.fit).shape.bend_x_m - common_m) <
                            2 * result.uncertainty.bend_std_m.front().x())
      ++counts.num_within_2_sigma;
  }
  return counts;
}

TEST(BendByViews, IsNoneWhereEachViewIsBentOtherwise) {
  const Counts counts = countBends(0, 0.0005, 20);
  EXPECT_GT(counts.num_by_noise, kNumSets / 2) << "noise alone would see bends";
  EXPECT_LE(counts.num_by_views, 5);  // 5 % by chance: 1.5 of 30
  EXPECT_LE(counts.num_estimated, counts.num_by_views);
}

TEST(BendByViews, IsFoundWhereTheViewsAgreeByAndLarge) {
  const Counts counts = countBends(0.001, 0.0005, 20);
  EXPECT_GE(counts.num_estimated, kNumSets - 1);
  EXPECT_GE(counts.num_within_2_sigma, 25) << "95 % of 30, by sigmas that allow for the views";
}

TEST(BendByViews, IsFoundInFewViewsToo) {
  EXPECT_GE(countBends(0.001, 0, 7).num_estimated, kNumSets - 2);
}

// One direction of bend in views that say equally much is the textbook case.
TEST(BendByViews, IsHotellingsTestForEqualViews) {
  constexpr int kNumSamples = 12;
  Random random(3);
  ShapeInformation information;
  Eigen::MatrixXd samples(2, kNumSamples);
  for (double& x : samples.reshaped()) x = random.normal();
  const Eigen::Vector2d mean = samples.rowwise().mean();
  for (int v = 0; v < kNumSamples; ++v)
    information.pulls.push_back(
        {.information = Eigen::MatrixXd::Identity(2, 2), .gradient = mean - samples.col(v)});
  const auto result = bendByViews(information, mean, Eigen::MatrixXd::Zero(0, 0), 1.0);
  ASSERT_TRUE(result);
  const Eigen::MatrixXd off = samples.colwise() - mean;
  const Eigen::Matrix2d covariance = off * off.transpose() / (kNumSamples - 1) / kNumSamples;
  const double t2 = mean.dot(covariance.inverse() * mean);
  EXPECT_NEAR(result->freedom, kNumSamples - 1, 1e-9);
  EXPECT_NEAR(result->f, (kNumSamples - 2) / (2.0 * (kNumSamples - 1)) * t2, 1e-9 * t2);
  EXPECT_NEAR(result->chance, std::pow(1 + 2 * result->f / (kNumSamples - 2), -0.5 * (kNumSamples - 2)),
              1e-12);
}

TEST(BendByViews, DecidesTogetherWithNoise) {
  EXPECT_FALSE(isBent(6, std::nullopt));
  EXPECT_TRUE(isBent(8, std::nullopt));
  EXPECT_TRUE(isBent(8, BendByViews{.f = 9, .freedom = 10, .chance = 0.01}));
  EXPECT_FALSE(isBent(8, BendByViews{.f = 1, .freedom = 10, .chance = 0.4}));
  EXPECT_FALSE(isBent(6, BendByViews{.f = 9, .freedom = 10, .chance = 0.01}));
}

}  // namespace
}  // namespace alidade
