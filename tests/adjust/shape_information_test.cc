// SPDX-License-Identifier: MIT
#include "alidade/adjust/noise/shape_information.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "alidade/adjust/board/solve.h"
#include "alidade/adjust/noise/covariance.h"
#include "support/fit_set.h"
#include "support/image_sizes.h"

namespace alidade {
namespace {

constexpr Checkerboard kBoard{.columns = 11, .rows = 8, .square_m = 0.05};  // half a metre wide
constexpr HuberLoss kShapeLoss{.threshold_px = 1.0};

AnyCamera camera() {
  return AnyCamera::make("radtan", std::vector<double>{900, 902, 640, 478, -0.25, 0.08, 4e-4, -3e-4, 0});
}

// Views of a bent board; the fit holds it flat.
Fit bentSet(const BoardShape& shape, double noise_px, std::uint64_t seed) {
  const SimulatedSet set = simulateSet(camera(), kQuadVga, 20, 0, seed, {}, kBoard);
  Fit fit = fitAt(set, set.camera, kShapeLoss);
  Random random(seed + 1000);
  for (FitView& view : fit.views) {
    for (Observation& o : view.corners) {
      const Projection projection =
          set.camera.project(cameraFromBoard(fit, view) * onBentBoard(kBoard, shape, o.p_board));
      EXPECT_TRUE(projection.ok());
      o.pixel = projection.pixel + noise_px * Eigen::Vector2d(random.normal(), random.normal());
    }
  }
  return fit;
}

void bendBy(Fit& fit, const Eigen::Vector2d& step_m) {
  BoardShape& shape = fit.boards.front().shape;
  shape.bend_x_m += step_m.x();
  shape.bend_y_m += step_m.y();
}

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
  Fit fit = bentSet(truth, 0, 1);
  for (int round = 0; round < 4; ++round) {
    fit = solve(std::move(fit));
    EXPECT_EQ(fit.summary.termination, Termination::kConverged);
    const auto information = shapeInformation(fit);
    ASSERT_TRUE(information);
    bendBy(fit, information->step_m);
  }
  EXPECT_NEAR(fit.boards.front().shape.bend_x_m, truth.bend_x_m, 1e-10);
  EXPECT_NEAR(fit.boards.front().shape.bend_y_m, truth.bend_y_m, 1e-10);
  fit = solve(std::move(fit));
  EXPECT_EQ(fit.summary.termination, Termination::kConverged);
  EXPECT_NEAR(fit.cameras.front().params[0], 900, 1e-5);
}

// What the steps lead to is the optimum of a fit in which the shape is one of the unknowns.
TEST(ShapeInformation, IsAtRestWhereTheShapeIsEstimated) {
  Fit fit = bentSet({.bend_x_m = 0.0006, .bend_y_m = -0.0009}, 0.1, 4);
  for (int round = 0; round < 4; ++round) {
    fit = solve(std::move(fit));
    bendBy(fit, shapeInformation(fit).value().step_m);
  }
  fit = solve(std::move(fit));
  Fit joint = fit;
  joint.boards.front() = {.target = kBoard, .shape = {}, .is_shape_fixed = false};
  joint = solve(std::move(joint));
  EXPECT_EQ(joint.summary.termination, Termination::kConverged);
  EXPECT_NEAR(joint.summary.cost, fit.summary.cost, 1e-9 * fit.summary.cost);
  EXPECT_NEAR(joint.boards.front().shape.bend_x_m, fit.boards.front().shape.bend_x_m, 1e-9);
  EXPECT_NEAR(joint.boards.front().shape.bend_y_m, fit.boards.front().shape.bend_y_m, 1e-9);
  EXPECT_NEAR(joint.cameras.front().params[0], fit.cameras.front().params[0], 1e-5);
  EXPECT_LT(shapeInformation(joint).value().drop, 1e-9 * joint.summary.cost);
}

TEST(ShapeInformation, ForetellsHowMuchTheCostDrops) {
  Fit fit = solve(bentSet({.bend_x_m = 0.0003, .bend_y_m = 0.0002}, 0.1, 2));
  const double before = fit.summary.cost;
  const auto information = shapeInformation(fit);
  ASSERT_TRUE(information);
  bendBy(fit, information->step_m);
  const double after = solve(std::move(fit)).summary.cost;
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
    Fit fit = solve(bentSet({}, kNoise, 100 + static_cast<std::uint64_t>(i)));
    ASSERT_EQ(fit.summary.termination, Termination::kConverged);
    const auto information = shapeInformation(fit);
    ASSERT_TRUE(information);
    sum2_x += std::pow(information->step_m.x() / kNoise, 2) / information->bend_inverse(0, 0);
    sum2_y += std::pow(information->step_m.y() / kNoise, 2) / information->bend_inverse(1, 1);
    sum_drop += information->drop / (kNoise * kNoise);
    bendBy(fit, information->step_m);
    fit = solve(std::move(fit));
    ASSERT_EQ(fit.summary.termination, Termination::kConverged);
    sum2_f += std::pow((fit.cameras.front().params[0] - 900) / kNoise, 2) / information->params_inverse(0, 0);
    // The bend costs the intrinsics some certainty.
    const auto flat = intrinsicsInformation(fit).inverse;
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
