// SPDX-License-Identifier: MIT
#include "alidade/calibrate/uncertainty/view_evidence.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "alidade/adjust/board/errors.h"
#include "alidade/adjust/board/solve.h"
#include "alidade/calibrate/calibrator.h"
#include "support/fit_set.h"
#include "support/image_sizes.h"

namespace alidade {
namespace {

constexpr double kNoisePx = 0.1;

SimulatedSet setOf(int num_views, std::uint64_t seed) {
  return simulateSet(AnyCamera::make("radtan", std::vector<double>{400, 400, 319, 241, -0.2, 0.04, 0, 0, 0}),
                     kVga, num_views, 0, seed);
}

// The bias of a solution from corners that are moved by noise and a part of their own.
template <class F>
ImageBias biasWith(const SimulatedSet& set, std::uint64_t seed, const F& part) {
  Random random(seed);
  Fit fit = fitAt(set, set.camera);
  for (std::size_t v = 0; v < fit.views.size(); ++v) {
    for (Observation& o : fit.views[v].corners)
      o.pixel += part(v, o) + kNoisePx * Eigen::Vector2d(random.normal(), random.normal());
  }
  fit = solve(std::move(fit));
  EXPECT_EQ(fit.summary.termination, Termination::kConverged);
  return imageBias(fit);
}

// Waves across the image, which no lens formula and no pose follows.
Eigen::Vector2d waveAt(const Eigen::Vector2d& pixel, double size_px) {
  constexpr double kPerPixel = 1.0 / 55;
  return size_px * std::sqrt(2.0) *
         Eigen::Vector2d(std::sin(kPerPixel * pixel.y()), std::sin(kPerPixel * pixel.x()));
}

TEST(ImageBias, SeesWhatAllViewsHaveInCommon) {
  constexpr int kSets = 10;
  for (std::uint64_t seed = 0; seed < kSets; ++seed) {
    const SimulatedSet set = setOf(20, seed);
    const ImageBias bias =
        biasWith(set, seed, [](std::size_t, const Observation& o) { return waveAt(o.pixel, kNoisePx); });
    EXPECT_TRUE(bias.isSeen()) << bias.z;
    // Some of the waves is taken up by poses and intrinsics, or is finer than the grid.
    EXPECT_GT(bias.rms_px, 0.3 * std::sqrt(2.0) * kNoisePx);
    EXPECT_LT(bias.rms_px, std::sqrt(2.0) * kNoisePx);
  }
}

TEST(ImageBias, SeesNoNoiseAndNothingThatAViewHasForItself) {
  int num_noise = 0;
  int num_own = 0;
  constexpr int kSets = 100;
  for (std::uint64_t seed = 0; seed < kSets; ++seed) {
    const SimulatedSet set = setOf(15, seed);
    const auto nothing = [](std::size_t, const Observation&) -> Eigen::Vector2d { return {0, 0}; };
    if (biasWith(set, seed, nothing).isSeen()) ++num_noise;
    // Each view bent by chance, three times as far as the noise.
    Random random(seed + kSets);
    std::vector<Eigen::Vector2d> bends;
    for (int v = 0; v < 15; ++v) bends.emplace_back(0.3 * random.normal(), 0.3 * random.normal());
    const auto bend = [&](std::size_t v, const Observation& o) -> Eigen::Vector2d {
      return bends[v] * std::sin(30 * o.p_board.x());
    };
    if (biasWith(set, seed, bend).isSeen()) ++num_own;
  }
  EXPECT_LE(num_noise, 1);
  EXPECT_LE(num_own, 1);
}

TEST(ImageBias, TellsALensFromABoard) {
  // A lens whose errors radtan cannot follow, and a board bent by chance at each corner.
  const SimulatedSet set = setOf(20, 1);
  std::vector<View> by_lens = set.views;
  std::vector<View> by_board = set.views;
  Random random(1);
  std::vector<Eigen::Vector3d> printed;
  for (int id = 0; id < set.board.numCorners(); ++id) {
    printed.push_back(set.board.corner(id) + Eigen::Vector3d(1e-4 * random.normal(), 1e-4 * random.normal(),
                                                             1e-4 * random.normal()));
  }
  for (std::size_t v = 0; v < set.views.size(); ++v) {
    for (std::size_t i = 0; i < set.views[v].corners.size(); ++i) {
      Corner& lens = by_lens[v].corners[i];
      lens.pixel += waveAt(lens.pixel, 0.3);
      Corner& board = by_board[v].corners[i];
      board.pixel = set.camera.project(set.poses[v] * printed[static_cast<std::size_t>(board.id)]).pixel;
    }
    addCornerNoise(by_lens[v], kNoisePx, random);
    addCornerNoise(by_board[v], kNoisePx, random);
  }
  const Calibration lens = calibrate(set.board, by_lens, {.model = "radtan"});
  const Calibration board =
      calibrate(set.board, by_board, {.model = "radtan", .board_shape = BoardShapeMode::kWarp});
  EXPECT_TRUE(lens.uncertainty.image_bias.isSeen()) << lens.uncertainty.image_bias.z;
  EXPECT_GT(lens.uncertainty.image_bias.rms_px, 0.1);
  EXPECT_GT(rms(board.fit), 1.2 * std::sqrt(2.0) * kNoisePx);
  EXPECT_FALSE(board.uncertainty.image_bias.isSeen()) << board.uncertainty.image_bias.z;
}

TEST(ImageBias, IsUnknownForOneView) {
  const SimulatedSet set = setOf(1, 1);
  const ImageBias bias = imageBias(fitAt(set, set.camera));
  EXPECT_TRUE(std::isnan(bias.z));
  EXPECT_FALSE(bias.isSeen());
}

}  // namespace
}  // namespace alidade
