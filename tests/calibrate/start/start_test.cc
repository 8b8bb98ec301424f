// SPDX-License-Identifier: MIT
#include "alidade/calibrate/start/start.h"

#include <gtest/gtest.h>

#include "alidade/adjust/board/solve.h"
#include "alidade/calibrate/calibrator.h"
#include "support/fit_set.h"
#include "support/start_sweep.h"

namespace alidade {
namespace {

// One set of each model at its narrowest, a middle and its widest field; start_bench runs the whole.
TEST(Start, EveryModelIsFoundWithoutAGuess) {
  std::vector<SweepCell> cells;
  const std::vector<SweepCell> all = sweepCells();
  for (std::size_t i = 0; i < all.size(); ++i) {
    const bool is_end =
        i == 0 || i + 1 == all.size() || all[i - 1].model != all[i].model || all[i + 1].model != all[i].model;
    if (is_end || all[i].fov_deg == 95) cells.push_back(all[i]);
  }
  int num_found = 0;
  for (const SweepCell& cell : cells) {
    SCOPED_TRACE(testing::Message() << cell.model << " " << cell.fov_deg);
    const SweepOutcome outcome = runSweepSet(cell, 0);
    EXPECT_EQ(outcome.error, "");
    EXPECT_TRUE(outcome.isAtOptimum() || outcome.isHeld() || !outcome.is_determined)
        << outcome.result.fit.summary.cost / outcome.cost_from_truth - 1;
    EXPECT_TRUE(outcome.isAtOptimum() || outcome.isWarned());
    EXPECT_GE(outcome.result.choice.start.num_solved, outcome.result.choice.start.num_agreed);
    num_found += outcome.isAtOptimum() || outcome.isHeld() ? 1 : 0;
  }
  EXPECT_EQ(cells.size(), 30U);
  EXPECT_GE(num_found, 28) << "sets whose views leave a valley are the exception";
}

// Two optima of a double sphere, xi above and below zero: the cost decides and not the start.
TEST(Start, ShapesWithTwoOptimaAreCompared) {
  int num_compared = 0;
  int num_sets = 0;
  for (std::uint64_t number = 0; number < 6; ++number) {
    const SweepOutcome outcome = runSweepSet({.model = "double_sphere", .fov_deg = 120}, number);
    EXPECT_TRUE(outcome.isAtOptimum()) << number;
    num_compared += outcome.result.choice.start.num_optima > 1 ? 1 : 0;
    ++num_sets;
  }
  EXPECT_EQ(num_sets, 6);
  EXPECT_GE(num_compared, 1);
}

// Steps beyond alpha = 1 are refused until none is left, close to the end and above the optimum, which lies
// at the end itself. From farther inside the solver gets there, and says so.
TEST(Start, DoesNotRestBesideTheEndOfARange) {
  const SweepOutcome outcome = runSweepSet({.model = "eucm", .fov_deg = 20}, 12);
  ASSERT_EQ(outcome.error, "");
  EXPECT_TRUE(outcome.isAtOptimum()) << outcome.result.fit.summary.cost / outcome.cost_from_truth - 1;
  EXPECT_EQ(onlyCamera(outcome.result.fit).params[4], 1);
  EXPECT_EQ(outcome.result.fit.summary.at_limit, (std::vector<FitParam>{{.camera = 0, .index = 4}}));
  EXPECT_TRUE(outcome.isWarned());
}

TEST(ImprovePoses, TurnsAWrongTiltBack) {
  Random random(5);
  const DrawnCamera drawn = drawCamera("pinhole", 35, random);
  const UserSet set = drawUserViews(drawn, 10, 0.1, random);
  const auto params = drawn.camera.parameters();
  PosedCamera camera{.params = {params.begin(), params.end()}, .poses = {set.poses.begin(), set.poses.end()}};
  const HuberLoss loss = startLoss(drawn.size);
  std::vector<std::vector<Observation>> corners;
  for (const View& view : set.views) corners.push_back(observationsOf(set.board, view));
  improvePoses("pinhole", corners, loss, camera);  // noise moves the best ones from the true ones
  EXPECT_FALSE(improvePoses("pinhole", corners, loss, camera)) << "good poses stay";
  camera.poses[4] = SE3{camera.poses[4]->rotation * SO3::exp({0.8, 0, 0}), camera.poses[4]->translation};
  camera.poses[7].reset();
  EXPECT_TRUE(improvePoses("pinhole", corners, loss, camera));
  for (std::size_t v = 0; v < set.poses.size(); ++v) {
    ASSERT_TRUE(camera.poses[v]);
    EXPECT_LE((camera.poses[v]->inverse() * set.poses[v]).log().norm(), 0.05) << v;
  }
}

// An optimum on the end of a parameter's range: a perspective seen as a unified camera has alpha = 0.
TEST(Bundle, FollowsTheEndOfARange) {
  Random random(11);
  const DrawnCamera drawn = drawCamera("radtan", 65, random);
  std::vector<double> params(drawn.camera.parameters().begin(), drawn.camera.parameters().end());
  params = {params[0], params[1], params[2], params[3], 0.005, 0, 0, 0, 0};  // pincushion
  const DrawnCamera pincushion{
      .camera = AnyCamera::make("radtan", params), .size = drawn.size, .rim_rad = drawn.rim_rad};
  const UserSet set = drawUserViews(pincushion, 12, 0.1, random);
  const Calibration result = calibrate(set.board, set.views, {.model = "ucm"});
  ASSERT_TRUE(result.dropped.outliers.empty() && result.dropped.views.empty());
  EXPECT_EQ(onlyCamera(result.fit).params[4], 0.0);
  EXPECT_EQ(result.fit.summary.at_limit, (std::vector<FitParam>{{.camera = 0, .index = 4}}));
  EXPECT_EQ(result.fit.summary.termination, Termination::kConverged);
  // With alpha = 0 it is a pinhole, whose optimum this must be.
  const Fit pinhole = solve(fitAt(set, "pinhole", {params.begin(), params.begin() + 4}, result.fit.loss));
  EXPECT_NEAR(result.fit.summary.cost, pinhole.summary.cost, 1e-6 * pinhole.summary.cost);
  EXPECT_NEAR(onlyCamera(result.fit).params[0], pinhole.cameras.front().params[0], 1e-3);
}

}  // namespace
}  // namespace alidade
