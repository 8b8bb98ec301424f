// SPDX-License-Identifier: MIT
// Boards that are printed otherwise than their SPEC says: another gap between tags, a stretch.
#include "alidade/calibrate/uncertainty/print_errors.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "alidade/calibrate/calibrator.h"
#include "alidade/simulate/observe.h"
#include "alidade/simulate/random_views.h"
#include "support/image_sizes.h"

namespace alidade {
namespace {

using testing::HasSubstr;

const std::vector<AnyCamera> kCameras = {
    AnyCamera::make("radtan", std::vector<double>{900, 902, 640, 478, -0.25, 0.08, 4e-4, -3e-4, 0}),
    AnyCamera::make("kannala_brandt", std::vector<double>{420, 421, 642, 479, 0.01, -0.003, 0.001, 0})};

AprilGrid gridWith(double gap) {
  return {.columns = 4, .rows = 3, .tag_m = 0.08, .gap = gap};
}

// @param outward_px  blooming: tags look larger by this on each side
std::vector<View> viewsOf(const AnyCamera& camera, const Board& board, int num_views, std::uint64_t seed,
                          double outward_px = 0, double most_of_image = 0.8) {
  Random random(seed);
  std::vector<View> views;
  const RandomViewOptions options{.min_fill = 0.5 * most_of_image, .max_fill = most_of_image};
  for (const SE3& pose : randomViews(camera, kQuadVga, board, num_views, random, options)) {
    View view = exactView(camera, kQuadVga, board, pose, "view_" + std::to_string(views.size()));
    for (Corner& corner : view.corners) {
      const int first = corner.id - corner.id % 2 - (corner.id / board.columns() % 2) * board.columns();
      const Eigen::Vector3d middle = 0.5 * (board.corner(first) + board.corner(first + board.columns() + 1));
      const Eigen::Vector2d out = corner.pixel - camera.project(pose * middle).pixel;
      corner.pixel += outward_px * std::sqrt(2.0) * out.normalized();
    }
    addCornerNoise(view, 0.1, random);
    for (Corner& corner : view.corners) corner.sigma_px = std::numeric_limits<double>::quiet_NaN();
    views.push_back(std::move(view));
  }
  return views;
}

const Diagnosis* gapIn(const Calibration& result) {
  const auto at = std::ranges::find(result.diagnoses, DiagnosisId("board_gap"), &Diagnosis::id);
  return at == result.diagnoses.end() ? nullptr : &*at;
}

TEST(BoardGap, IsSeenNamedAndUsed) {
  const Board stated = gridWith(0.3);
  int num_sets = 0;
  for (const AnyCamera& camera : kCameras) {
    for (const double gap : {0.2, 0.25, 0.29, 0.31, 0.36}) {
      for (const int num_views : {8, 16}) {
        const auto views =
            viewsOf(camera, gridWith(gap), num_views, 70 + static_cast<std::uint64_t>(num_sets));
        const Calibration result = calibrate(stated, views, {.model = std::string(camera.modelId())});
        const Diagnosis* named = gapIn(result);
        ASSERT_NE(named, nullptr) << camera.modelId() << " " << gap << " " << num_views;
        EXPECT_EQ(named->severity, std::abs(gap - 0.3) > 0.013 ? Severity::kFailure : Severity::kWarning);
        EXPECT_THAT(named->message(), HasSubstr("not 0.3"));
        EXPECT_EQ(onlyBoard(result.fit).target.refutedGap(), 0.3);
        EXPECT_NEAR(*onlyBoard(result.fit).target.gap(), gap, 1.5e-3);
        for (int i = 0; i < 4; ++i) {
          EXPECT_LT(std::abs(onlyCamera(result.fit).params[static_cast<std::size_t>(i)] -
                             camera.parameters()[static_cast<std::size_t>(i)]),
                    5 * result.uncertainty.parameterStd(i))
              << camera.modelId() << " " << gap << " " << num_views << " " << i;
        }
        ++num_sets;
      }
    }
  }
  EXPECT_EQ(num_sets, 20);
}

// Blooming makes tags larger by 0.15 px on each side, and gaps smaller.
TEST(BoardGap, OfARightSpecIsKept) {
  int num_sets = 0;
  int num_named = 0;
  for (const AnyCamera& camera : kCameras) {
    for (const double outward_px : {0.0, 0.15}) {
      for (int i = 0; i < 5; ++i) {
        const auto views =
            viewsOf(camera, gridWith(0.3), 12, 170 + static_cast<std::uint64_t>(num_sets), outward_px);
        const Calibration result = calibrate(gridWith(0.3), views, {.model = std::string(camera.modelId())});
        num_named += gapIn(result) != nullptr ? 1 : 0;
        ++num_sets;
      }
    }
  }
  EXPECT_EQ(num_sets, 20);
  EXPECT_EQ(num_named, 0);
}

// Blooming of small tags looks like another gap, and one cannot tell which it is.
TEST(BoardGap, ThatBloomingExplainsIsNamedButNotUsed) {
  int num_sets = 0;
  for (const double outward_px : {0.12, 0.2, -0.2}) {
    for (std::uint64_t seed = 0; seed < 3; ++seed) {
      const Board stated = AprilGrid{.columns = 4, .rows = 3, .tag_m = 0.03, .gap = 0.3};
      const AnyCamera camera = AnyCamera::make("pinhole", std::vector<double>{500, 500, 640, 480});
      std::vector<View> views = viewsOf(camera, stated, 10, 270 + seed, outward_px, 0.2);
      const Calibration result = calibrate(stated, views, {.model = "pinhole"});
      EXPECT_FALSE(onlyBoard(result.fit).target.refutedGap()) << outward_px;
      EXPECT_TRUE(result.isUsable()) << outward_px;
      const Diagnosis* named = gapIn(result);
      EXPECT_TRUE(named == nullptr || named->severity == Severity::kWarning) << outward_px;
      EXPECT_GT(sizeStd(onlyBoard(result.fit), result.uncertainty.common_errors, 0), 1e-3);
      ++num_sets;
    }
  }
  EXPECT_EQ(num_sets, 9);
}

TEST(BoardGap, OfTwoBoardsIsThatOfTheWrongOne) {
  std::vector<Board> boards = {gridWith(0.3), gridWith(0.3)};
  std::vector<View> views = viewsOf(kCameras[0], boards[0], 10, 5);
  for (View& view : viewsOf(kCameras[0], gridWith(0.26), 10, 6)) {
    view.image += "_other";
    view.board = 1;
    views.push_back(std::move(view));
  }
  const Calibration result = calibrate(boards, views, {.model = "radtan"});
  EXPECT_FALSE(result.fit.boards[0].target.refutedGap());
  EXPECT_EQ(result.fit.boards[1].target.refutedGap(), 0.3);
  EXPECT_NEAR(*result.fit.boards[1].target.gap(), 0.26, 1.5e-3);
}

}  // namespace
}  // namespace alidade
