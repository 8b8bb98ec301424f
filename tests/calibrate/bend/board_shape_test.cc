// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>

#include "alidade/calibrate/calibrator.h"
#include "support/simulated_set.h"

namespace alidade {
namespace {

constexpr ImageSize kSize{1280, 960};
constexpr double kFocal = 900;
constexpr Checkerboard kBoard{.columns = 11, .rows = 8, .square_m = 0.05};  // half a metre wide

// Views by a camera that sees the board as it is: bent.
std::vector<View> viewsOf(const BoardShape& shape, int num_views, double noise_px, std::uint64_t seed) {
  const AnyCamera camera = AnyCamera::make(
      "radtan", std::vector<double>{kFocal, kFocal + 2, 640, 478, -0.25, 0.08, 4e-4, -3e-4, 0});
  SimulatedSet set = simulateSet(camera, kSize, num_views, 0, seed, {}, kBoard);
  Random random(seed + 1000);
  for (std::size_t v = 0; v < set.views.size(); ++v) {
    for (Corner& corner : set.views[v].corners) {
      const Projection projection =
          camera.project(set.poses[v] * onBentBoard(kBoard, shape, kBoard.corner(corner.id)));
      EXPECT_TRUE(projection.ok());
      corner.pixel = projection.pixel + noise_px * Eigen::Vector2d(random.normal(), random.normal());
    }
  }
  return set.views;
}

TEST(BoardShape, OfABentBoardIsFoundAndTheFocalLengthIsRight) {
  constexpr int kNumSets = 20;
  double sum_bent = 0;
  double sum_flat = 0;
  double sum_z2 = 0;
  for (int i = 0; i < kNumSets; ++i) {
    // Two ways to bend by a millimetre.
    const BoardShape truth =
        i % 2 == 0 ? BoardShape{.bend_x_m = 0.001} : BoardShape{.bend_x_m = 0.0006, .bend_y_m = 0.001};
    const auto views = viewsOf(truth, 20, 0.1, static_cast<std::uint64_t>(i));
    const CalibrationResult bent = calibrate(kBoard, views);
    ASSERT_TRUE(bent.shape.is_estimated) << "set " << i << ", F " << bent.shape.f;
    EXPECT_TRUE(bent.isUsable());
    EXPECT_TRUE(bent.outliers.empty());
    EXPECT_LT(std::abs(bent.shape.shape.bend_x_m - truth.bend_x_m), 5 * bent.shape.std_m.x());
    EXPECT_LT(std::abs(bent.shape.shape.bend_y_m - truth.bend_y_m), 5 * bent.shape.std_m.y());
    const double z = (bent.camera.parameters()[0] - kFocal) / bent.parameterStd(0);
    sum_z2 += z * z;
    sum_bent += bent.camera.parameters()[0] - kFocal;
    const CalibrationResult flat = calibrate(kBoard, views, {.board_shape = BoardShapeMode::kFlat});
    EXPECT_FALSE(flat.shape.is_estimated);
    EXPECT_GT(flat.rms_px, 1.2 * bent.rms_px);
    // What the report says of a flat board is what a calibration with one finds, but for the robust loss,
    // which was made for the smaller errors.
    EXPECT_NEAR(bent.shape.flat_rms_px, flat.rms_px, 0.03 * flat.rms_px);
    const double moved = std::abs(flat.camera.parameters()[0] - bent.camera.parameters()[0]);
    EXPECT_NEAR(bent.shape.flat_params[0], flat.camera.parameters()[0], 0.1 * moved);
    sum_flat += std::abs(flat.camera.parameters()[0] - kFocal);
  }
  std::printf("fx off by %.3f px on average with the bend, by %.3f px with the board held flat\n",
              sum_bent / kNumSets, sum_flat / kNumSets);
  EXPECT_LT(sum_z2 / kNumSets, 2.0);  // 1 +- 0.32
  EXPECT_LT(std::abs(sum_bent / kNumSets), 0.3);
  EXPECT_GT(sum_flat / kNumSets, 1.0);
}

TEST(BoardShape, OfAFlatBoardIsFlat) {
  constexpr int kNumSets = 60;
  int num_flat = 0;
  for (int i = 0; i < kNumSets; ++i) {
    const CalibrationResult result =
        calibrate(kBoard, viewsOf({}, 12, 0.1, 500 + static_cast<std::uint64_t>(i)));
    EXPECT_TRUE(std::isfinite(result.shape.f));
    num_flat += result.shape.is_estimated ? 0 : 1;
  }
  EXPECT_GE(num_flat, kNumSets - 1);  // once in a thousand by chance
}

TEST(BoardShape, IsEstimatedOfAFlatBoardToo) {
  const CalibrationResult result =
      calibrate(kBoard, viewsOf({}, 15, 0.1, 7), {.board_shape = BoardShapeMode::kWarp});
  ASSERT_TRUE(result.shape.is_estimated);
  EXPECT_LT(std::abs(result.shape.shape.bend_x_m), 4 * result.shape.std_m.x());
  EXPECT_LT(std::abs(result.shape.shape.bend_y_m), 4 * result.shape.std_m.y());
  EXPECT_LT(result.shape.std_m.maxCoeff(), 1e-4);
}

TEST(BoardShape, IsNotFeignedByOutliers) {
  constexpr int kNumSets = 15;
  int num_flat = 0;
  for (int i = 0; i < kNumSets; ++i) {
    auto views = viewsOf({}, 12, 0.1, 900 + static_cast<std::uint64_t>(i));
    Random random(static_cast<std::uint64_t>(i));
    for (View& view : views) {
      for (Corner& corner : view.corners) {
        if (random.uniform() < 0.05) corner.pixel += 10 * Eigen::Vector2d(random.normal(), random.normal());
      }
    }
    num_flat += calibrate(kBoard, views).shape.is_estimated ? 0 : 1;
  }
  EXPECT_GE(num_flat, kNumSets - 1);
}

TEST(BoardShape, SaysSoWhereTheBoardCannotTell) {
  constexpr Checkerboard kNarrow{
      .columns = 9, .rows = 2, .square_m = 0.05};  // its ends are all it has one way
  const AnyCamera camera = AnyCamera::make("pinhole", std::vector<double>{900, 902, 640, 478});
  const SimulatedSet set = simulateSet(camera, kSize, 12, 0.1, 1, {}, kNarrow);
  const CalibrationResult result =
      calibrate(kNarrow, set.views, {.model = "pinhole", .board_shape = BoardShapeMode::kWarp});
  EXPECT_FALSE(result.shape.is_determined);
  EXPECT_FALSE(result.shape.is_estimated);
  bool is_told = false;
  for (const Finding& finding : result.findings) is_told = is_told || finding.id == "bend_unknown";
  EXPECT_TRUE(is_told);
}

}  // namespace
}  // namespace alidade
