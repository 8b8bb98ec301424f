// SPDX-License-Identifier: MIT
// Circle grids before a wide lens: whether the centroids of their discs' images give true cameras.
#include <cmath>
#include <cstdio>
#include <numbers>

#include <gtest/gtest.h>

#include "alidade/calibrate/calibrator.h"
#include "alidade/core/parallel.h"
#include "alidade/simulate/observe.h"
#include "alidade/simulate/random_views.h"
#include "support/image_sizes.h"

namespace alidade {
namespace {

const Board kBoard = CircleGrid{.columns = 10, .rows = 8, .spacing_m = 0.025, .diameter_m = 0.015};

// 120 degrees across the width.
const std::vector<double> kTruth = {615, 614, 641, 477, -0.02, 0.004, -0.002, 0.0003};

// Of the polygon that a disc's outline is seen as, by triangles about its first point.
Eigen::Vector2d outlineCentroid(const AnyCamera& camera, const SE3& camera_from_board, int id) {
  constexpr int kPoints = 600;
  std::vector<Eigen::Vector2d> outline;
  for (int i = 0; i < kPoints; ++i) {
    const double angle = 2 * std::numbers::pi * i / kPoints;
    const Eigen::Vector3d at =
        kBoard.corner(id) + kBoard.discRadius() * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0);
    outline.push_back(camera.project(camera_from_board * at).pixel);
  }
  Eigen::Vector2d sum(0, 0);
  double areas = 0;
  for (std::size_t i = 1; i + 1 < outline.size(); ++i) {
    const Eigen::Vector2d a = outline[i] - outline[0];
    const Eigen::Vector2d b = outline[i + 1] - outline[0];
    const double area = a.x() * b.y() - a.y() * b.x();
    sum += area * (a + b) / 3;
    areas += area;
  }
  return outline[0] + sum / areas;
}

std::vector<View> circleViews(std::uint64_t seed) {
  Random random(seed);
  const AnyCamera camera = AnyCamera::make("kannala_brandt", kTruth);
  std::vector<View> views;
  for (const SE3& pose : randomViews(camera, kQuadVga, kBoard, 20, random)) {
    views.push_back(exactView(camera, kQuadVga, kBoard, pose, "view_" + std::to_string(views.size())));
    for (Corner& corner : views.back().corners) corner.pixel = outlineCentroid(camera, pose, corner.id);
    addCornerNoise(views.back(), 0.05, random);
  }
  return views;
}

struct FocalScores {
  double mean = 0;     // of error / stated sigma, over fx and fy
  double covered = 0;  // share within 1.96
};

// With what is on `board` taken for what was seen.
FocalScores focalScores(const Board& board, std::size_t num_sets) {
  std::vector<std::vector<double>> scores(num_sets);
  parallelFor(num_sets, 0, [&](std::size_t i) {
    const Calibration result = calibrate(board, circleViews(streamSeed(31, i)), {.model = "kannala_brandt"});
    for (const std::size_t k : {0U, 1U}) {
      scores[i].push_back((onlyCamera(result.fit).params[k] - kTruth[k]) /
                          result.uncertainty.parameterStd(static_cast<int>(k)));
    }
  });
  FocalScores of;
  for (const auto& set : scores) {
    for (const double score : set) {
      of.mean += score / (2.0 * static_cast<double>(num_sets));
      of.covered += (std::abs(score) < 1.96 ? 1.0 : 0.0) / (2.0 * static_cast<double>(num_sets));
    }
  }
  return of;
}

TEST(CircleSigmas, AreTrueBeforeAWideLens) {
  const FocalScores scores = focalScores(kBoard, 100);
  std::printf("focal length: mean error %+.3f sigma, %.1f %% within 95 %%\n", scores.mean,
              100 * scores.covered);
  EXPECT_LE(std::abs(scores.mean), 0.3);
  EXPECT_GE(scores.covered, 0.92);
  EXPECT_LE(scores.covered, 0.98);
}

// What others do. 25 sets are enough: the mean over them has a spread of 0.2, a fifth of the limit.
TEST(CircleSigmas, AreNotForTheMiddlesOfTheDiscs) {
  const FocalScores scores = focalScores(Checkerboard{.columns = 10, .rows = 8, .square_m = 0.025}, 25);
  std::printf("middles of discs: mean error %+.3f sigma\n", scores.mean);
  EXPECT_GT(std::abs(scores.mean), 1);
}

}  // namespace
}  // namespace alidade
