// SPDX-License-Identifier: MIT
// Calibrations from views of several boards.
#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>

#include "alidade/adjust/board/errors.h"
#include "alidade/calibrate/bend/shape_fit.h"
#include "alidade/calibrate/calibrator.h"
#include "alidade/calibrate/start/prepared_views.h"
#include "alidade/core/error.h"
#include "alidade/simulate/observe.h"
#include "alidade/simulate/random_views.h"
#include "support/image_sizes.h"
#include "support/message_of.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

const std::vector<double> kSharedTruth = {900, 902, 640, 478, -0.25, 0.08, 4e-4, -3e-4, 0};

// Half a metre wide.
std::vector<Board> twoBoards() {
  return {CharucoBoard{
              .columns = 11, .rows = 8, .square_m = 0.05, .marker_m = 0.0375, .dictionary = "DICT_4X4_250"},
          AprilGrid{.columns = 6, .rows = 5, .tag_m = 0.06, .gap = 0.3, .first_id = 100}};
}

// How the boards are in truth, beside what the calibration takes them for.
struct Flaw {
  BoardShape shape;
  double stretch = 0;  // of the width
};

// Both boards in the first third of the images, one of them in each of the others.
std::vector<View> viewsOf(const std::vector<Board>& boards, const std::vector<Flaw>& flaws, int num_images,
                          std::uint64_t seed) {
  const AnyCamera camera = AnyCamera::make("radtan", kSharedTruth);
  Random random(seed);
  std::vector<View> views;
  for (std::size_t b = 0; b < boards.size(); ++b) {
    const std::vector<SE3> poses = randomViews(camera, kQuadVga, boards[b], num_images, random);
    for (int i = 0; i < num_images; ++i) {
      const bool is_shared = 3 * i < num_images;
      if (!is_shared && static_cast<std::size_t>(i) % boards.size() != b) continue;
      View view{.image = "image_" + std::to_string(i), .size = kQuadVga, .corners = {}, .board = b};
      for (int id = 0; id < boards[b].numCorners(); ++id) {
        Eigen::Vector3d p = onBentBoard(boards[b], flaws[b].shape, boards[b].corner(id));
        p.x() *= 1 + flaws[b].stretch;
        const Projection projection = camera.project(poses[static_cast<std::size_t>(i)] * p);
        if (projection.ok()) view.corners.push_back({.id = id, .pixel = projection.pixel});
      }
      addCornerNoise(view, 0.1, random);
      for (Corner& corner : view.corners) corner.sigma_px = std::numeric_limits<double>::quiet_NaN();
      views.push_back(std::move(view));
    }
  }
  return views;
}

const std::vector<Flaw> kFlat(2);
const std::vector<Flaw> kFirstBent = {{.shape = {.bend_x_m = 0.001, .bend_y_m = -0.0006}}, {}};

TEST(SeveralBoards, GiveTheTrueCameraAndTheBendOfTheBoardThatIsBent) {
  constexpr int kNumSets = 12;
  const std::vector<Board> boards = twoBoards();
  int num_params = 0;
  int num_within = 0;
  double sum_z2 = 0;
  int num_flat = 0;
  for (int i = 0; i < kNumSets; ++i) {
    SCOPED_TRACE(i);
    // The bent one may be any of the two.
    const bool is_first = i % 2 == 0;
    const std::vector<Flaw> flaws = is_first ? kFirstBent : std::vector<Flaw>{kFirstBent[1], kFirstBent[0]};
    const std::size_t bent = is_first ? 0 : 1;
    const Calibration result = calibrate(
        boards, viewsOf(boards, flaws, 15, 40 + static_cast<std::uint64_t>(i)), {.model = "radtan"});
    EXPECT_TRUE(result.isUsable());
    EXPECT_TRUE(result.dropped.views.empty() && result.dropped.outliers.empty());
    ASSERT_EQ(result.fit.boards.size(), 2U);
    ASSERT_EQ(result.choice.shapes.size(), 2U);
    ASSERT_FALSE(result.fit.boards[bent].is_shape_fixed) << "F " << result.choice.shapes[bent].f;
    const BoardShape& shape = result.fit.boards[bent].shape;
    const Eigen::Vector2d& std_m = result.uncertainty.bend_std_m[bent];
    EXPECT_LT(std::abs(shape.bend_x_m - flaws[bent].shape.bend_x_m), 4 * std_m.x());
    EXPECT_LT(std::abs(shape.bend_y_m - flaws[bent].shape.bend_y_m), 4 * std_m.y());
    EXPECT_LT(std_m.maxCoeff(), 1e-4);
    num_flat += result.fit.boards[1 - bent].is_shape_fixed ? 1 : 0;
    for (std::size_t p = 0; p < kSharedTruth.size(); ++p) {
      const double z = (onlyCamera(result.fit).params[p] - kSharedTruth[p]) /
                       result.uncertainty.parameterStd(static_cast<int>(p));
      EXPECT_LT(std::abs(z), 4.5) << result.camera().parameterNames()[p];
      num_within += std::abs(z) < 3 ? 1 : 0;
      sum_z2 += z * z;
      ++num_params;
    }
  }
  EXPECT_EQ(num_params, 9 * kNumSets);
  EXPECT_GE(num_within, num_params - 3) << "within 3 sigma";
  std::printf("mean squared z of the parameters %.2f\n", sum_z2 / num_params);
  EXPECT_GT(sum_z2 / num_params, 0.5);
  EXPECT_LT(sum_z2 / num_params, 1.7);
  EXPECT_GE(num_flat, kNumSets - 1) << "the flat board is left flat";
}

TEST(SeveralBoards, AreEachBentAsTheyAre) {
  const std::vector<Board> boards = twoBoards();
  const std::vector<Flaw> flaws = {{.shape = {.bend_x_m = 0.001}},
                                   {.shape = {.bend_x_m = -0.0005, .bend_y_m = 0.0008}}};
  const Calibration result = calibrate(boards, viewsOf(boards, flaws, 18, 3), {.model = "radtan"});
  ASSERT_THAT(estimatedShapes(result.fit), ElementsAre(0U, 1U));
  for (std::size_t b = 0; b < 2; ++b) {
    const Eigen::Vector2d& std_m = result.uncertainty.bend_std_m[b];
    EXPECT_LT(std::abs(result.fit.boards[b].shape.bend_x_m - flaws[b].shape.bend_x_m), 4 * std_m.x());
    EXPECT_LT(std::abs(result.fit.boards[b].shape.bend_y_m - flaws[b].shape.bend_y_m), 4 * std_m.y());
    EXPECT_EQ(result.choice.shapes[b].flat_params.size(), kSharedTruth.size());
    EXPECT_GT(result.choice.shapes[b].flat_rms_px, rms(result.fit));
  }
}

TEST(SeveralBoards, ThatAreHeldFlatAreNamedWhereTheyAreBent) {
  const std::vector<Board> boards = twoBoards();
  const Calibration result = calibrate(boards, viewsOf(boards, kFirstBent, 15, 5),
                                       {.model = "radtan", .board_shape = BoardShapeMode::kFlat});
  ASSERT_TRUE(result.uncertainty.ignored_bend.has_value());
  EXPECT_THAT(result.uncertainty.ignored_bend->boards, ElementsAre(0U));
  const auto told = std::ranges::find(result.diagnoses, "bend_ignored", &Diagnosis::id);
  ASSERT_NE(told, result.diagnoses.end());
  EXPECT_THAT(told->evidence, HasSubstr(boards[0].spec()));
  const double z = (onlyCamera(result.fit).params[0] - kSharedTruth[0]) / result.uncertainty.parameterStd(0);
  EXPECT_LT(std::abs(z), 4) << "the stated uncertainty allows for it";
}

TEST(SeveralBoards, AreBlamedOneByOneForAWrongPrint) {
  const std::vector<Board> boards = twoBoards();
  const std::vector<Flaw> flaws = {{}, {.shape = {}, .stretch = 0.01}};
  const Calibration result = calibrate(boards, viewsOf(boards, flaws, 18, 8), {.model = "radtan"});
  int num_errors = 0;
  for (const CommonError& error : result.uncertainty.common_errors) {
    if (error.cause != CommonCause::kStretch) continue;
    EXPECT_NEAR(error.value, flaws[error.board].stretch, 5 * error.sigma) << error.board;
    EXPECT_EQ(error.isSignificant(), error.board == 1);
    ++num_errors;
  }
  EXPECT_EQ(num_errors, 2);
  int num_told = 0;
  for (const Diagnosis& diagnosis : result.diagnoses) {
    if (diagnosis.id != "board_not_square") continue;
    EXPECT_THAT(diagnosis.cause, HasSubstr("(" + boards[1].spec() + ")"));
    ++num_told;
  }
  EXPECT_EQ(num_told, 1);
}

TEST(SeveralBoards, GiveTheSameInAnyOrderOfTheViews) {
  const std::vector<Board> boards = twoBoards();
  std::vector<View> views = viewsOf(boards, kFlat, 12, 9);
  const Calibration one = calibrate(boards, views, {.model = "radtan"});
  std::ranges::reverse(views);
  const Calibration other = calibrate(boards, views, {.model = "radtan"});
  EXPECT_EQ(onlyCamera(one.fit).params, onlyCamera(other.fit).params);
  ASSERT_EQ(one.fit.views.size(), views.size());
  for (std::size_t v = 0; v < views.size(); ++v) {
    EXPECT_EQ(one.fit.views[v].image, other.fit.views[v].image);
    EXPECT_EQ(one.fit.views[v].board, other.fit.views[v].board);
    EXPECT_EQ(views[other.fit.views[v].source].board, other.fit.views[v].board);
  }
}

TEST(SeveralBoards, OfWhichOnlyOneIsSeenGiveWhatThatOneGives) {
  const std::vector<Board> boards = twoBoards();
  std::vector<View> views = viewsOf(boards, kFlat, 12, 10);
  std::erase_if(views, [](const View& view) { return view.board != 0; });
  const Calibration alone = calibrate(boards[0], views, {.model = "radtan"});
  const Calibration both = calibrate(boards, views, {.model = "radtan"});
  EXPECT_EQ(onlyCamera(alone.fit).params, onlyCamera(both.fit).params);
  EXPECT_EQ(alone.uncertainty.parameterStd(0), both.uncertainty.parameterStd(0));
  EXPECT_EQ(numViews(both.fit, 1), 0U);
  EXPECT_FALSE(both.choice.shapes[1].is_determined);
}

TEST(SeveralBoards, WhoseViewsAreWrongAreRefused) {
  const std::vector<Board> boards = twoBoards();
  const std::vector<View> good = viewsOf(boards, kFlat, 9, 11);
  const auto messageFor = [&](auto&& change) {
    std::vector<View> views = good;
    change(views);
    return messageOf([&] { (void)calibrate(boards, views, {.model = "radtan"}); });
  };
  EXPECT_THAT(messageFor([](auto& views) { views[1].board = 2; }),
              AllOf(HasSubstr("image_1"), HasSubstr("a view of board 2"), HasSubstr("there are 2")));
  EXPECT_THAT(messageFor([](auto& views) { views.push_back(views[0]); }),
              AllOf(HasSubstr("image_0"), HasSubstr("two views with this name"),
                    HasSubstr("one view per image and board")));
  // The ChArUco board has 70 corners, the AprilGrid 120.
  EXPECT_THAT(messageFor([](auto& views) { views[0].corners[0].id = 110; }),
              AllOf(HasSubstr("corner id 110"), HasSubstr("0 to 69 on charuco")));
}

TEST(SeveralBoards, DoNotRepeatEachOther) {
  const std::vector<Board> boards = {Checkerboard{.columns = 9, .rows = 6, .square_m = 0.02},
                                     Checkerboard{.columns = 9, .rows = 7, .square_m = 0.02}};
  std::vector<View> views;
  const AnyCamera camera = AnyCamera::make("radtan", kSharedTruth);
  Random random(4);
  for (const SE3& pose : randomViews(camera, kQuadVga, boards[1], 4, random)) {
    views.push_back(
        exactView(camera, kQuadVga, boards[0], pose, "image_" + std::to_string(views.size() / 2)));
    views.push_back(views.back());  // the same corners, of the other board
    views.back().board = 1;
  }
  const PreparedViews given = prepareViews(boards, views);
  EXPECT_EQ(given.views.size(), 8U);
  EXPECT_TRUE(given.dropped.repeated.empty());
}

}  // namespace
}  // namespace alidade
