// SPDX-License-Identifier: MIT
#include "alidade/calibrate/shape_information.h"

#include <gtest/gtest.h>

#include <cmath>

#include "alidade/calibrate/covariance.h"
#include "alidade/calibrate/start.h"
#include "support/simulated_set.h"

namespace alidade {
namespace {

constexpr ImageSize kSize{1280, 960};
constexpr Checkerboard kBoard{.columns = 11, .rows = 8, .square_m = 0.05};  // half a metre wide
constexpr HuberLoss kLoss{.threshold_px = 1.0};

AnyCamera camera() {
  return AnyCamera::make("radtan", std::vector<double>{900, 902, 640, 478, -0.25, 0.08, 4e-4, -3e-4, 0});
}

// Views of a bent board, as the solver takes them with the board held flat.
struct BentSet {
  std::vector<std::vector<Observation>> views;
  BundleState state;

  BentSet(const BoardShape& shape, double noise_px, std::uint64_t seed) {
    const SimulatedSet set = simulateSet(camera(), kSize, 20, 0, seed, {}, kBoard);
    Random random(seed + 1000);
    views = observationsOf(kBoard, set.views);
    const auto params = set.camera.parameters();
    state.params.assign(params.begin(), params.end());
    state.camera_from_board = set.poses;
    for (std::size_t v = 0; v < views.size(); ++v) {
      for (Observation& o : views[v]) {
        const Projection projection =
            set.camera.project(set.poses[v] * onBentBoard(kBoard, shape, o.p_board));
        EXPECT_TRUE(projection.ok());
        o.pixel = projection.pixel + noise_px * Eigen::Vector2d(random.normal(), random.normal());
      }
    }
  }

  void bend(const BoardShape& shape) {
    for (auto& view : views) {
      for (Observation& o : view) o.p_board = onBentBoard(kBoard, shape, o.p_board);
    }
  }
  BundleSummary solve() { return solveBundle("radtan", views, state, {.loss = kLoss}); }
};

TEST(BoardShape, BendsTheMiddleAndLeavesTheCorners) {
  const BoardShape shape{.bend_x_m = 0.002, .bend_y_m = -0.001};
  EXPECT_NEAR(onBentBoard(kBoard, shape, {0, 0, 0}).z(), 0, 1e-18);
  EXPECT_NEAR(onBentBoard(kBoard, shape, {0.5, 0.35, 0}).z(), 0, 1e-18);
  EXPECT_NEAR(onBentBoard(kBoard, shape, {0.25, 0.175, 0}).z(), 0.001, 1e-15);
  EXPECT_NEAR(onBentBoard(kBoard, shape, {0.25, 0, 0}).z(), 0.002, 1e-15);
  EXPECT_NEAR(onBentBoard(kBoard, shape, {0, 0.175, 0}).z(), -0.001, 1e-15);
  EXPECT_NEAR(onBentBoard(kBoard, shape, {0.125, 0, 0}).z(), 0.0015, 1e-15);
}

TEST(ShapeInformation, StepsLeadToTheTrueBend) {
  const BoardShape truth{.bend_x_m = 0.001, .bend_y_m = -0.0004};
  BentSet set(truth, 0, 1);
  BoardShape shape;
  for (int round = 0; round < 4; ++round) {
    EXPECT_EQ(set.solve().termination, Termination::kConverged);
    const auto information = shapeInformation("radtan", kBoard, set.views, set.state, kLoss);
    ASSERT_TRUE(information);
    shape.bend_x_m += information->step_m.x();
    shape.bend_y_m += information->step_m.y();
    set.bend(shape);
  }
  EXPECT_NEAR(shape.bend_x_m, truth.bend_x_m, 1e-10);
  EXPECT_NEAR(shape.bend_y_m, truth.bend_y_m, 1e-10);
  EXPECT_EQ(set.solve().termination, Termination::kConverged);
  EXPECT_NEAR(set.state.params[0], 900, 1e-5);
}

TEST(ShapeInformation, ForetellsHowMuchTheCostDrops) {
  BentSet set({.bend_x_m = 0.0003, .bend_y_m = 0.0002}, 0.1, 2);
  const double before = set.solve().cost;
  const auto information = shapeInformation("radtan", kBoard, set.views, set.state, kLoss);
  ASSERT_TRUE(information);
  set.bend({.bend_x_m = information->step_m.x(), .bend_y_m = information->step_m.y()});
  const double after = set.solve().cost;
  EXPECT_NEAR(information->drop, 2 * (before - after), 0.02 * information->drop);
}

TEST(ShapeInformation, StatesTheSpreadOfTheBendAndOfTheIntrinsics) {
  constexpr int kNumSets = 60;
  constexpr double kNoise = 0.1;
  double sum2_x = 0;
  double sum2_y = 0;
  double sum2_f = 0;
  double sum_drop = 0;
  for (int i = 0; i < kNumSets; ++i) {
    BentSet set({}, kNoise, 100 + static_cast<std::uint64_t>(i));
    ASSERT_EQ(set.solve().termination, Termination::kConverged);
    const auto information = shapeInformation("radtan", kBoard, set.views, set.state, kLoss);
    ASSERT_TRUE(information);
    sum2_x += std::pow(information->step_m.x() / kNoise, 2) / information->bend_inverse(0, 0);
    sum2_y += std::pow(information->step_m.y() / kNoise, 2) / information->bend_inverse(1, 1);
    sum_drop += information->drop / (kNoise * kNoise);
    set.bend({.bend_x_m = information->step_m.x(), .bend_y_m = information->step_m.y()});
    ASSERT_EQ(set.solve().termination, Termination::kConverged);
    sum2_f += std::pow((set.state.params[0] - 900) / kNoise, 2) / information->params_inverse(0, 0);
    // The bend costs the intrinsics some certainty.
    const auto flat = intrinsicsInformation("radtan", set.views, set.state).inverse;
    ASSERT_TRUE(flat);
    EXPECT_GT(information->params_inverse(0, 0), (*flat)(0, 0));
  }
  // Mean squares of 60 standard normals: 1 +- 0.18; the drop follows a chi-squared distribution of 2.
  EXPECT_NEAR(sum2_x / kNumSets, 1, 0.55);
  EXPECT_NEAR(sum2_y / kNumSets, 1, 0.55);
  EXPECT_NEAR(sum2_f / kNumSets, 1, 0.55);
  EXPECT_NEAR(sum_drop / kNumSets, 2, 0.8);
}

}  // namespace
}  // namespace alidade
