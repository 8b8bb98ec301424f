// SPDX-License-Identifier: MIT
#include "alidade/calibrate/cross_validation.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "alidade/calibrate/calibrator.h"
#include "alidade/calibrate/start.h"
#include "support/simulated_set.h"

namespace alidade {
namespace {

constexpr ImageSize kSize{.width = 640, .height = 480};
constexpr double kNoisePx = 0.1;
const std::vector<double> kTruth = {535, 534, 322, 238, -0.28, 0.08, 8e-4, -4e-4, -0.01};

SimulatedSet noisySet(int num_views, std::uint64_t seed) {
  return simulateSet(AnyCamera::make("radtan", kTruth), kSize, num_views, kNoisePx, seed);
}

BundleState solved(const SimulatedSet& set, const BundleOptions& options = {}) {
  BundleState state{.params = kTruth, .camera_from_board = set.poses};
  static_cast<void>(solveBundle("radtan", observationsOf(set.board, set.views), state, options));
  return state;
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
  const auto all = observationsOf(set.board, set.views);
  const BundleOptions options{.loss = {.threshold_px = 0.3}};
  const BundleState full = solved(set, options);
  const auto held_out = heldOutErrors("radtan", set.board.square_m, all, full, options);
  ASSERT_TRUE(held_out);
  EXPECT_EQ(held_out->num_folds, 5);
  int num_checked = 0;
  double farthest = 0;
  for (std::size_t v = 0; v < all.size(); ++v) {
    std::vector<std::vector<Observation>> others;
    BundleState camera{.params = kTruth, .camera_from_board = {}};
    for (std::size_t w = 0; w < all.size(); ++w) {
      if (foldOf(w, all.size()) == foldOf(v, all.size())) continue;
      others.push_back(all[w]);
      camera.camera_from_board.push_back(set.poses[w]);
    }
    ASSERT_EQ(solveBundle("radtan", others, camera, options).termination, Termination::kConverged);
    for (int parity = 0; parity < 2; ++parity) {
      std::vector<Observation> half;
      for (const Corner& c : set.views[v].corners) {
        if ((c.id % 9 + c.id / 9) % 2 != parity) continue;
        half.push_back(all[v][static_cast<std::size_t>(&c - set.views[v].corners.data())]);
      }
      BundleState pose{.params = camera.params, .camera_from_board = {set.poses[v]}};
      BundleOptions held = options;
      held.constraint.held.resize(kTruth.size());
      std::iota(held.constraint.held.begin(), held.constraint.held.end(), 0);
      ASSERT_EQ(solveBundle("radtan", std::span(&half, 1), pose, held).termination, Termination::kConverged);
      const auto errors = reprojectionErrors("radtan", camera.params, pose.camera_from_board[0], all[v]);
      for (std::size_t i = 0; i < all[v].size(); ++i) {
        const int id = set.views[v].corners[i].id;
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
    const CalibrationResult result = calibrate(noisySet(20, seed).board, noisySet(20, seed).views);
    EXPECT_GT(result.holdout.rms_px, result.rms_px);
    EXPECT_EQ(result.holdout.num_corners, result.num_corners);
    EXPECT_EQ(result.holdout.num_unseen, 0);
    sum += result.holdout.rms_px * result.holdout.rms_px / 2;
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
  auto all = observationsOf(set.board, set.views);
  const BundleState full = solved(set);
  std::vector<Observation> few;  // 2 x 3 corners, three of a colour
  for (const std::size_t i : {0u, 1u, 2u, 9u, 10u, 11u}) few.push_back(all[4][i]);
  all[4] = few;
  const auto held_out = heldOutErrors("radtan", set.board.square_m, all, full, {});
  ASSERT_TRUE(held_out);
  EXPECT_TRUE(held_out->px[4].empty());
  EXPECT_EQ(holdoutReport(held_out).num_corners, 9 * 54);
}

TEST(HeldOutErrors, NeedNoSolveWhereEverythingIsHeld) {
  const SimulatedSet set = noisySet(6, 4);
  BundleOptions options;
  options.constraint.held = {0, 1, 2, 3, 4, 5, 6, 7, 8};
  const BundleState full{.params = kTruth, .camera_from_board = set.poses};
  const auto held_out =
      heldOutErrors("radtan", set.board.square_m, observationsOf(set.board, set.views), full, options);
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
