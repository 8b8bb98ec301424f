// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>

#include "alidade/adjust/board/errors.h"
#include "alidade/calibrate/bend/shape_fit.h"
#include "alidade/calibrate/calibrator.h"
#include "support/image_sizes.h"
#include "support/simulated_set.h"

namespace alidade {
namespace {

constexpr double kBentFocal = 900;
constexpr Checkerboard kBentBoard{.columns = 11, .rows = 8, .square_m = 0.05};  // half a metre wide

// Views by a camera that sees the board as it is: bent.
std::vector<View> viewsOf(const BoardShape& shape, int num_views, double noise_px, std::uint64_t seed) {
  const AnyCamera camera = AnyCamera::make(
      "radtan", std::vector<double>{kBentFocal, kBentFocal + 2, 640, 478, -0.25, 0.08, 4e-4, -3e-4, 0});
  SimulatedSet set = simulateSet(camera, kQuadVga, num_views, 0, seed, {}, kBentBoard);
  Random random(seed + 1000);
  for (std::size_t v = 0; v < set.views.size(); ++v) {
    for (Corner& corner : set.views[v].corners) {
      const Projection projection =
          camera.project(set.poses[v] * onBentBoard(kBentBoard, shape, kBentBoard.corner(corner.id)));
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
    const Calibration bent = calibrate(kBentBoard, views, {.model = "radtan"});
    ASSERT_TRUE(isShapeEstimated(bent.fit)) << "set " << i << ", F " << bent.choice.shapes.front().f;
    EXPECT_TRUE(bent.isUsable());
    EXPECT_TRUE(bent.dropped.outliers.empty());
    EXPECT_LT(std::abs(onlyBoard(bent.fit).shape.bend_x_m - truth.bend_x_m),
              5 * bent.uncertainty.bend_std_m.front().x());
    EXPECT_LT(std::abs(onlyBoard(bent.fit).shape.bend_y_m - truth.bend_y_m),
              5 * bent.uncertainty.bend_std_m.front().y());
    const double z = (onlyCamera(bent.fit).params[0] - kBentFocal) / bent.uncertainty.parameterStdByNoise(0);
    sum_z2 += z * z;
    sum_bent += onlyCamera(bent.fit).params[0] - kBentFocal;
    const Calibration flat =
        calibrate(kBentBoard, views, {.model = "radtan", .board_shape = BoardShapeMode::kFlat});
    EXPECT_FALSE(isShapeEstimated(flat.fit));
    EXPECT_GT(rms(flat.fit), 1.2 * rms(bent.fit));
    // What the report says of a flat board is what a calibration with one finds, but for the robust loss,
    // which was made for the smaller errors.
    EXPECT_NEAR(bent.choice.shapes.front().flat_rms_px, rms(flat.fit), 0.03 * rms(flat.fit));
    const double moved = std::abs(onlyCamera(flat.fit).params[0] - onlyCamera(bent.fit).params[0]);
    EXPECT_NEAR(bent.choice.shapes.front().flat_params[0], onlyCamera(flat.fit).params[0], 0.1 * moved);
    sum_flat += std::abs(onlyCamera(flat.fit).params[0] - kBentFocal);
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
    const Calibration result =
        calibrate(kBentBoard, viewsOf({}, 12, 0.1, 500 + static_cast<std::uint64_t>(i)), {.model = "radtan"});
    EXPECT_TRUE(std::isfinite(result.choice.shapes.front().f));
    num_flat += isShapeEstimated(result.fit) ? 0 : 1;
  }
  EXPECT_GE(num_flat, kNumSets - 1);  // once in a thousand by chance
}

TEST(BoardShape, IsEstimatedOfAFlatBoardToo) {
  const Calibration result = calibrate(kBentBoard, viewsOf({}, 15, 0.1, 7),
                                       {.model = "radtan", .board_shape = BoardShapeMode::kWarp});
  ASSERT_TRUE(isShapeEstimated(result.fit));
  EXPECT_LT(std::abs(onlyBoard(result.fit).shape.bend_x_m), 4 * result.uncertainty.bend_std_m.front().x());
  EXPECT_LT(std::abs(onlyBoard(result.fit).shape.bend_y_m), 4 * result.uncertainty.bend_std_m.front().y());
  EXPECT_LT(result.uncertainty.bend_std_m.front().maxCoeff(), 1e-4);
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
    num_flat += isShapeEstimated(calibrate(kBentBoard, views, {.model = "radtan"}).fit) ? 0 : 1;
  }
  EXPECT_GE(num_flat, kNumSets - 1);
}

TEST(BoardShape, SaysSoWhereTheBoardCannotTell) {
  constexpr Checkerboard kNarrow{
      .columns = 9, .rows = 2, .square_m = 0.05};  // its ends are all it has one way
  const AnyCamera camera = AnyCamera::make("pinhole", std::vector<double>{900, 902, 640, 478});
  const SimulatedSet set = simulateSet(camera, kQuadVga, 12, 0.1, 1, {}, kNarrow);
  const Calibration result =
      calibrate(kNarrow, set.views, {.model = "pinhole", .board_shape = BoardShapeMode::kWarp});
  EXPECT_FALSE(result.choice.shapes.front().is_determined);
  EXPECT_FALSE(isShapeEstimated(result.fit));
  bool is_told = false;
  for (const Diagnosis& finding : result.diagnoses) is_told = is_told || finding.id == "bend_unknown";
  EXPECT_TRUE(is_told);
}

}  // namespace
}  // namespace alidade
