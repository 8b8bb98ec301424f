// SPDX-License-Identifier: MIT
// Boards that look the same after a turn, numbered from either end.
#include "alidade/calibrate/clean/turned_views.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "alidade/adjust/board/errors.h"
#include "alidade/calibrate/calibrator.h"
#include "alidade/simulate/observe.h"
#include "alidade/simulate/random_views.h"
#include "alidade/target/board_turns.h"
#include "support/image_sizes.h"

namespace alidade {
namespace {

const AnyCamera kCamera =
    AnyCamera::make("radtan", std::vector<double>{900, 902, 640, 478, -0.25, 0.08, 4e-4, -3e-4, 0});

// Each point is off its place in all directions.
std::vector<View> viewsOf(const Board& board, double scatter_m, int num_views, std::uint64_t seed) {
  Random random(seed);
  BoardShape shape;
  for (int id = 0; id < board.numCorners(); ++id) {
    Eigen::Vector3d offset;
    for (double& value : offset) value = scatter_m * random.normal();
    shape.offsets_m.push_back(offset);
  }
  std::vector<View> views;
  for (const SE3& pose : randomViews(kCamera, kQuadVga, board, num_views, random)) {
    View view = exactView(kCamera, kQuadVga, board, pose, "view_" + std::to_string(views.size()));
    for (Corner& corner : view.corners)
      corner.pixel = kCamera.project(pose * pointOn(board, shape, corner.id)).pixel;
    addCornerNoise(view, 0.1, random);
    for (Corner& corner : view.corners) corner.sigma_px = std::numeric_limits<double>::quiet_NaN();
    views.push_back(std::move(view));
  }
  return views;
}

// Turns of the views at random.
std::vector<View> turnedAtRandom(const Board& board, std::vector<View> views, std::uint64_t seed) {
  Random random(seed);
  const std::vector<BoardTurn> turns = boardTurns(board);
  for (View& view : views) {
    const auto turn = static_cast<std::size_t>(random.uniform(0, static_cast<double>(turns.size()) - 1e-9));
    for (Corner& corner : view.corners) corner.id = turns[turn].id_of[static_cast<std::size_t>(corner.id)];
    std::ranges::sort(view.corners, {}, &Corner::id);
  }
  return views;
}

// Largest difference of fx, fy, cx and cy, in stated standard deviations of the second.
double difference(const Calibration& a, const Calibration& b) {
  double most = 0;
  for (int i = 0; i < 4; ++i) {
    const auto at = static_cast<std::size_t>(i);
    most = std::max(most, std::abs(onlyCamera(a.fit).params[at] - onlyCamera(b.fit).params[at]) /
                              b.uncertainty.parameterStd(i));
  }
  return most;
}

TEST(TurnedViews, AreNumberedAlikeWhereTheBoardIsUneven) {
  const std::vector<Board> boards = {Checkerboard{.columns = 8, .rows = 6, .square_m = 0.03},
                                     Checkerboard{.columns = 9, .rows = 7, .square_m = 0.03},
                                     Checkerboard{.columns = 6, .rows = 6, .square_m = 0.04}};
  int num_sets = 0;
  int num_same = 0;
  for (const Board& board : boards) {
    for (const double scatter_m : {1e-4, 4e-4}) {
      for (const int num_views : {10, 40}) {
        const auto seed = static_cast<std::uint64_t>(60 + num_sets);
        const std::vector<View> alike = viewsOf(board, scatter_m, num_views, seed);
        const Calibration right = calibrate(board, alike, {.model = "radtan"});
        const Calibration mixed = calibrate(board, turnedAtRandom(board, alike, seed), {.model = "radtan"});
        EXPECT_LT(rms(mixed.fit), 1.05 * rms(right.fit)) << board.spec() << " " << scatter_m;
        num_same += difference(right, mixed) < 1e-3 ? 1 : 0;
        EXPECT_LT(difference(right, mixed), 2) << board.spec() << " " << scatter_m;
        EXPECT_EQ(right.verdict(), mixed.verdict()) << board.spec() << " " << scatter_m;
        ++num_sets;
      }
    }
  }
  EXPECT_EQ(num_sets, 12);
  EXPECT_GE(num_same, 10);
}

TEST(TurnedViews, OfFlatAndOfEvenlyNumberedBoardsStayAsTheyAre) {
  const Board board = Checkerboard{.columns = 8, .rows = 6, .square_m = 0.03};
  int num_sets = 0;
  for (const double scatter_m : {0.0, 2e-4}) {
    for (std::uint64_t seed = 0; seed < 6; ++seed) {
      std::vector<View> views = viewsOf(board, scatter_m, 15, 90 + seed);
      if (scatter_m == 0) views = turnedAtRandom(board, views, 7 + seed);
      const Calibration result = calibrate(board, views, {.model = "radtan"});
      for (const FitView& view : result.fit.views) {
        const View& given = views[view.source];
        for (const Observation& corner : view.corners) {
          const auto same = std::ranges::find(given.corners, corner.id, &Corner::id);
          ASSERT_NE(same, given.corners.end());
          EXPECT_EQ(same->pixel, corner.pixel) << view.image;
        }
      }
      ++num_sets;
    }
  }
  EXPECT_EQ(num_sets, 12);
}

}  // namespace
}  // namespace alidade
