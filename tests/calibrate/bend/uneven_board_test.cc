// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numeric>

#include "alidade/adjust/board/errors.h"
#include "alidade/adjust/noise/board_offsets.h"
#include "alidade/adjust/noise/cross_validation.h"
#include "alidade/calibrate/calibrator.h"
#include "support/image_sizes.h"
#include "support/simulated_set.h"

namespace alidade {
namespace {

constexpr double kFocal = 900;
constexpr double kNoise = 0.05;
constexpr Checkerboard kBoard{.columns = 9, .rows = 7, .square_m = 0.03};
constexpr double kInPlane = 2e-4;  // scatter of the points, metres
constexpr double kAcross = 5e-4;

BoardShape scattered(double share, Random& random) {
  BoardShape shape;
  for (int i = 0; i < Board(kBoard).numCorners(); ++i) {
    shape.offsets_m.push_back(share * Eigen::Vector3d(kInPlane * random.normal(), kInPlane * random.normal(),
                                                      kAcross * random.normal()));
  }
  return shape;
}

struct UnevenSet {
  BoardShape shape;
  std::vector<View> views;
};

// As a printer stretches a sheet: by this share in x, less in y.
void stretch(double share, BoardShape& shape) {
  const Board board(kBoard);
  for (int i = 0; i < board.numCorners(); ++i) {
    const Eigen::Vector3d p = board.corner(i) - board.middle();
    shape.offsets_m[static_cast<std::size_t>(i)] += Eigen::Vector3d(share * p.x(), -share * p.y(), 0);
  }
}

UnevenSet unevenSet(double share, int num_views, std::uint64_t seed, double stretched = 0) {
  const AnyCamera camera = AnyCamera::make(
      "radtan", std::vector<double>{kFocal, kFocal + 2, 640, 478, -0.25, 0.08, 4e-4, -3e-4, 0});
  SimulatedSet set = simulateSet(camera, kQuadVga, num_views, 0, seed, {}, kBoard);
  Random random(seed + 1000);
  UnevenSet result{.shape = scattered(share, random), .views = {}};
  stretch(stretched, result.shape);
  for (std::size_t v = 0; v < set.views.size(); ++v) {
    for (Corner& corner : set.views[v].corners) {
      const Projection projection = camera.project(set.poses[v] * pointOn(kBoard, result.shape, corner.id));
      EXPECT_TRUE(projection.ok());
      corner.pixel = projection.pixel + kNoise * Eigen::Vector2d(random.normal(), random.normal());
    }
  }
  result.views = std::move(set.views);
  return result;
}

// Of the offsets' components across the board, less what a plane and a bend take up.
double correlationAcross(const BoardShape& a, const BoardShape& b) {
  double ab = 0;
  double aa = 0;
  double bb = 0;
  for (std::size_t i = 0; i < a.offsets_m.size(); ++i) {
    ab += a.offsets_m[i].z() * b.offsets_m[i].z();
    aa += a.offsets_m[i].z() * a.offsets_m[i].z();
    bb += b.offsets_m[i].z() * b.offsets_m[i].z();
  }
  return ab / std::sqrt(aa * bb);
}

TEST(UnevenBoard, IsFoundAndItsPointsAreWhereTheyAre) {
  constexpr int kNumSets = 12;
  int num_within = 0;
  double sum_z2 = 0;
  for (int i = 0; i < kNumSets; ++i) {
    const UnevenSet set = unevenSet(1, 15, static_cast<std::uint64_t>(i));
    const Calibration found = calibrate(kBoard, set.views, {.model = "radtan"});
    ASSERT_TRUE(onlyBoard(found.fit).isUneven()) << "set " << i;
    EXPECT_TRUE(found.choice.even_excess->is_significant);
    EXPECT_NEAR(rms(found.fit), std::sqrt(2.0) * kNoise, 0.2 * kNoise);
    EXPECT_NEAR(found.uncertainty.coordinate_sigma_px, kNoise, 0.1 * kNoise);
    EXPECT_GT(correlationAcross(onlyBoard(found.fit).shape, set.shape), 0.9);
    EXPECT_NEAR(offsetRms(onlyBoard(found.fit).shape).x(), kInPlane, 0.3 * kInPlane);
    const Calibration even =
        calibrate(kBoard, set.views, {.model = "radtan", .board_shape = BoardShapeMode::kWarp});
    EXPECT_FALSE(onlyBoard(even.fit).isUneven());
    EXPECT_GT(rms(even.fit), 3 * rms(found.fit));
    const double error = onlyCamera(found.fit).params[0] - kFocal;
    const double z = error / found.uncertainty.parameterStd(0);
    num_within += std::abs(z) < 1.96 ? 1 : 0;
    sum_z2 += z * z;
  }
  EXPECT_GE(num_within, kNumSets - 2);
  EXPECT_LT(sum_z2, 2.0 * kNumSets);
}

// Scattered points say little of a stretch by themselves, which must not make it seem known.
TEST(UnevenBoard, StatesItsUncertaintyIfItIsStretchedToo) {
  constexpr int kNumSets = 12;
  constexpr std::size_t kNumParams = 9;
  const std::vector<double> truth = {kFocal, kFocal + 2, 640, 478, -0.25, 0.08, 4e-4, -3e-4, 0};
  std::vector<double> squares(kNumParams);
  int num_within = 0;
  for (int i = 0; i < kNumSets; ++i) {
    const UnevenSet set = unevenSet(1, 15, static_cast<std::uint64_t>(200 + i), 0.003);
    const Calibration found = calibrate(kBoard, set.views, {.model = "radtan"});
    ASSERT_TRUE(onlyBoard(found.fit).isUneven()) << "set " << i;
    for (std::size_t k = 0; k < kNumParams; ++k) {
      const double z =
          (onlyCamera(found.fit).params[k] - truth[k]) / found.uncertainty.parameterStd(static_cast<int>(k));
      num_within += std::abs(z) < 1.96 ? 1 : 0;
      squares[k] += z * z / kNumSets;
    }
  }
  EXPECT_GE(num_within, static_cast<int>(0.88 * static_cast<double>(kNumParams) * kNumSets));
  for (std::size_t k = 0; k < kNumParams; ++k) EXPECT_LT(squares[k], 2.2) << k;  // chi^2 of 12: 1 in 100
}

TEST(UnevenBoard, OfAnEvenOneNothingIsLeft) {
  constexpr int kNumSets = 20;
  int num_uneven = 0;
  for (int i = 0; i < kNumSets; ++i) {
    const UnevenSet set = unevenSet(0, 15, static_cast<std::uint64_t>(100 + i));
    const Calibration found = calibrate(kBoard, set.views, {.model = "radtan"});
    num_uneven += onlyBoard(found.fit).isUneven() ? 1 : 0;
  }
  EXPECT_EQ(num_uneven, 0);
}

TEST(UnevenBoard, AskedForOfAnEvenOneChangesNothingThatCounts) {
  const UnevenSet set = unevenSet(0, 15, 7);
  const Calibration even = calibrate(kBoard, set.views, {.model = "radtan"});
  const Calibration asked =
      calibrate(kBoard, set.views, {.model = "radtan", .board_shape = BoardShapeMode::kUneven});
  EXPECT_LT(offsetRms(onlyBoard(asked.fit).shape).maxCoeff(), 3e-5);
  EXPECT_NEAR(onlyCamera(asked.fit).params[0], onlyCamera(even.fit).params[0],
              even.uncertainty.parameterStd(0));
}

TEST(UnevenBoard, IsFoundByACameraThatIsKnown) {
  const UnevenSet set = unevenSet(1, 15, 11);
  const AnyCamera camera = AnyCamera::make(
      "radtan", std::vector<double>{kFocal, kFocal + 2, 640, 478, -0.25, 0.08, 4e-4, -3e-4, 0});
  const Calibration found = calibrate(kBoard, set.views,
                                      {.model = "radtan",
                                       .initial = InitialCamera{.camera = camera, .size = kQuadVga},
                                       .held = {"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"}});
  ASSERT_TRUE(onlyBoard(found.fit).isUneven());
  EXPECT_GT(correlationAcross(onlyBoard(found.fit).shape, set.shape), 0.9);
}

// Whether or not the views share one camera with the board, a lens that lacks a parameter is no board.
TEST(UnevenBoard, ALensBeyondItsModelIsNone) {
  const AnyCamera camera =
      AnyCamera::make("kannala_brandt", std::vector<double>{400, 401, 640, 478, 0.02, -0.01, 0.004, -0.001});
  const SimulatedSet set = simulateSet(camera, kQuadVga, 20, kNoise, 3, {}, kBoard);
  const Calibration found = calibrate(kBoard, set.views, {.model = "pinhole"});
  EXPECT_FALSE(onlyBoard(found.fit).isUneven());
}

// The offsets' uncertainty by the joint equations is that of the whole problem: with the scatter all but zero
// nothing is added, and what is added grows with it.
TEST(UnevenBoard, AddsToTheUncertaintyOfTheCamera) {
  const UnevenSet set = unevenSet(1, 15, 3);
  Fit fit = calibrate(kBoard, set.views, {.model = "radtan"}).fit;
  double before = 0;
  for (const double precision : {1e16, 1e8, 1e6, 1e5}) {
    onlyBoard(fit).offset_precision = Eigen::Vector2d::Constant(precision);
    const auto share = offsetShare(fit);
    ASSERT_TRUE(share);
    const double now = (*share)(0, 0);
    EXPECT_GT(now, before);
    before = now;
  }
  onlyBoard(fit).offset_precision.reset();
  EXPECT_TRUE(offsetShare(fit)->isZero(0));
}

TEST(UnevenBoard, ComesToTheSameAnswerFromAnyStart) {
  const UnevenSet set = unevenSet(1, 15, 5);
  const Fit fit = calibrate(kBoard, set.views, {.model = "radtan"}).fit;
  Fit moved = fit;
  for (Eigen::Vector3d& offset : onlyBoard(moved).shape.offsets_m) offset *= 0.5;
  const auto again = withOffsets(moved, OffsetScatter::kKeep, nullptr);
  ASSERT_TRUE(again);
  for (std::size_t i = 0; i < onlyBoard(fit).shape.offsets_m.size(); ++i) {
    EXPECT_NEAR((onlyBoard(*again).shape.offsets_m[i] - onlyBoard(fit).shape.offsets_m[i]).norm(), 0, 1e-8);
  }
}

// Held-out errors end the search for the offsets early, and share the folds out to threads.
TEST(UnevenBoard, HasTheSameHeldOutErrorsForAnyNumberOfThreads) {
  const UnevenSet set = unevenSet(1, 20, 6);
  const Fit fit = calibrate(kBoard, set.views, {.model = "radtan"}).fit;
  ASSERT_TRUE(onlyBoard(fit).isUneven());
  const auto one = heldOutErrors(fit, 1);
  const auto five = heldOutErrors(fit, 5);
  ASSERT_TRUE(one && five);
  EXPECT_EQ(one->px, five->px);
  Fit moved = fit;
  for (Eigen::Vector3d& offset : onlyBoard(moved).shape.offsets_m) offset *= 0.9;
  const auto early = withOffsets(moved, OffsetScatter::kKeep, nullptr, kHeldOutAtRest);
  ASSERT_TRUE(early);
  for (std::size_t i = 0; i < onlyBoard(fit).shape.offsets_m.size(); ++i) {
    const double off = (onlyBoard(*early).shape.offsets_m[i] - onlyBoard(fit).shape.offsets_m[i]).norm();
    EXPECT_LT(off, 0.1 * kHeldOutAtRest * kBoard.square_m);  // 0.3 um, less than 0.001 px
  }
}

// The share that the first scatter leaves lies on the side of the limit that the best scatter's does.
TEST(UnevenBoard, IsRecognisedAsFlatFromTheFirstScatter) {
  constexpr double kLimit = 0.9;
  constexpr std::array<std::size_t, 1> kOnlyBoard = {0};
  int num_early = 0;
  int num_sets = 0;
  for (const double share : {0.0, 0.05, 0.1, 0.2, 1.0}) {
    for (const int num_views : {8, 20}) {
      const UnevenSet set = unevenSet(share, num_views, static_cast<std::uint64_t>(100 + num_sets));
      const Fit flat =
          calibrate(kBoard, set.views, {.model = "radtan", .board_shape = BoardShapeMode::kFlat}).fit;
      const Fit started = startedUneven(flat, kOnlyBoard);
      const double whole = varianceLeftByOffsets(started);
      const double with_limit = varianceLeftByOffsets(started, kLimit);
      EXPECT_EQ(with_limit > kLimit, whole > kLimit) << share << ' ' << num_views;
      num_early += with_limit != whole ? 1 : 0;
      ++num_sets;
    }
  }
  EXPECT_EQ(num_sets, 10);
  EXPECT_GE(num_early, 1);
}

}  // namespace
}  // namespace alidade
