// SPDX-License-Identifier: MIT
#include "alidade/adjust/noise/cross_validation.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "alidade/adjust/board/errors.h"
#include "alidade/adjust/board/solve.h"
#include "alidade/calibrate/calibrator.h"
#include "support/fit_set.h"
#include "support/image_sizes.h"

namespace alidade {
namespace {

constexpr double kNoisePx = 0.1;
const std::vector<double> kTruth = {535, 534, 322, 238, -0.28, 0.08, 8e-4, -4e-4, -0.01};

SimulatedSet noisySet(int num_views, std::uint64_t seed) {
  return simulateSet(AnyCamera::make("radtan", kTruth), kVga, num_views, kNoisePx, seed);
}

Fit solved(const SimulatedSet& set, HuberLoss loss = {.threshold_px = 1}) {
  return solve(fitAt(set, "radtan", kTruth, loss));
}

TEST(Folds, AreOfAboutOneSizeAndSpreadOverTheSequence) {
  int num_checked = 0;
  for (std::size_t num_views = 3; num_views <= 240; ++num_views) {
    std::vector<std::size_t> sizes(static_cast<std::size_t>(numFolds(num_views)), 0);
    std::vector<std::set<std::size_t>> quarters(sizes.size());
    std::size_t num_changes = 0;
    for (std::size_t v = 0; v < num_views; ++v) {
      const auto fold = static_cast<std::size_t>(foldOf(v, num_views));
      ASSERT_LT(fold, sizes.size());
      ++sizes[fold];
      quarters[fold].insert(4 * v / num_views);
      if (v > 0 && foldOf(v, num_views) != foldOf(v - 1, num_views)) ++num_changes;
    }
    const auto [least, most] = std::minmax_element(sizes.begin(), sizes.end());
    EXPECT_GE(*least, 1u);
    // Single views, or four stretches of which each may be longer by one.
    EXPECT_LE(*most - *least, num_views < 20 ? 1u : 4u) << num_views;
    if (num_views < 40) continue;
    // Neighbours are together, but for the ends of 20 stretches.
    EXPECT_EQ(num_changes, 19u) << num_views;
    for (const auto& seen : quarters) EXPECT_EQ(seen.size(), 4u) << num_views;
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 201);
}

// The definition, step by step, with the solver for everything.
TEST(HeldOutErrors, AreThoseOfCamerasAndPosesThatNeverSawTheCorner) {
  const SimulatedSet set = noisySet(12, 1);
  const Fit full = solved(set, {.threshold_px = 0.3});
  const std::size_t num_views = full.views.size();
  const auto held_out = heldOutErrors(full);
  ASSERT_TRUE(held_out);
  EXPECT_EQ(held_out->num_folds, 5);
  int num_checked = 0;
  double farthest = 0;
  for (std::size_t v = 0; v < num_views; ++v) {
    std::vector<bool> is_out(num_views);
    for (std::size_t w = 0; w < num_views; ++w) is_out[w] = foldOf(w, num_views) == foldOf(v, num_views);
    const Fit camera = solve(withoutViews(full, is_out));
    ASSERT_EQ(camera.summary.termination, Termination::kConverged);
    for (int parity = 0; parity < 2; ++parity) {
      Fit half{.cameras = camera.cameras, .boards = camera.boards, .loss = camera.loss};
      half.cameras.front().constraint.held.resize(kTruth.size());
      std::iota(half.cameras.front().constraint.held.begin(), half.cameras.front().constraint.held.end(), 0);
      std::vector<Observation> corners;
      for (const Observation& c : full.views[v].corners) {
        if ((c.id % 9 + c.id / 9) % 2 == parity) corners.push_back(c);
      }
      addView(half, 0, corners, set.poses[v]);
      half = solve(std::move(half));
      ASSERT_EQ(half.summary.termination, Termination::kConverged);
      half.views.front().corners = full.views[v].corners;
      const auto errors = viewErrors(half, half.views.front());
      for (std::size_t i = 0; i < errors.size(); ++i) {
        const int id = full.views[v].corners[i].id;
        if ((id % 9 + id / 9) % 2 == parity) continue;
        farthest = std::max(farthest, (errors[i] - held_out->px[v][i]).norm());
        ++num_checked;
      }
    }
  }
  EXPECT_EQ(num_checked, 12 * 54);
  // The folds are solved to 1e-8 of the cost, far below the errors' scatter.
  EXPECT_LT(farthest, 1e-3 * kNoisePx);
}

TEST(HeldOutErrors, AreAsLargeAsNoiseAndUncertaintyTogether) {
  double sum = 0;
  int count = 0;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const Calibration result =
        calibrate(noisySet(20, seed).board, noisySet(20, seed).views, {.model = "radtan"});
    EXPECT_GT(result.uncertainty.holdout.rms_px, rms(result.fit));
    EXPECT_EQ(result.uncertainty.holdout.num_corners, numCorners(result.fit));
    EXPECT_EQ(result.uncertainty.holdout.num_unseen, 0);
    sum += result.uncertainty.holdout.rms_px * result.uncertainty.holdout.rms_px / 2;
    ++count;
  }
  EXPECT_EQ(count, 10);
  // A pose from 27 corners: 6 of 54 coordinates' worth of noise comes on top; so does what nine parameters
  // from 16 views do not know, and corners at the board's border are extrapolated to.
  const double sigma = std::sqrt(sum / count);
  EXPECT_GT(sigma, kNoisePx * std::sqrt(1 + 6.0 / 54) * 0.985);  // three standard errors of 10 sets
  EXPECT_LT(sigma, kNoisePx * std::sqrt(1 + 6.0 / 54) * 1.1);
}

TEST(HeldOutErrors, LeaveOutViewsWhoseHalvesGiveNoPose) {
  const SimulatedSet set = noisySet(10, 3);
  Fit fit = solved(set);
  std::vector<Observation> few;  // 2 x 3 corners, three of a colour
  for (const std::size_t i : {0u, 1u, 2u, 9u, 10u, 11u}) few.push_back(fit.views[4].corners[i]);
  fit.views[4].corners = few;
  const auto held_out = heldOutErrors(fit);
  ASSERT_TRUE(held_out);
  EXPECT_TRUE(held_out->px[4].empty());
  EXPECT_EQ(holdoutReport(held_out).num_corners, 9 * 54);
}

TEST(HeldOutErrors, NeedNoSolveWhereEverythingIsHeld) {
  const SimulatedSet set = noisySet(6, 4);
  Fit fit = fitAt(set, "radtan", kTruth, {.threshold_px = 1});
  fit.cameras.front().constraint.held = {0, 1, 2, 3, 4, 5, 6, 7, 8};
  const auto held_out = heldOutErrors(fit);
  ASSERT_TRUE(held_out);
  EXPECT_NEAR(holdoutReport(held_out).rms_px, kNoisePx * std::sqrt(2 * (1 + 6.0 / 54)), 0.15 * kNoisePx);
}

TEST(HeldOutErrors, AreUnknownWhereTwoViewsGiveNoCamera) {
  HoldoutReport report = holdoutReport(std::nullopt);
  EXPECT_TRUE(std::isnan(report.rms_px));
  EXPECT_EQ(report.num_folds, 0);
}

}  // namespace
}  // namespace alidade
