// SPDX-License-Identifier: MIT
#include "alidade/simulate/observe.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "alidade/core/error.h"
#include "alidade/target/board_turns.h"
#include "support/image_sizes.h"

namespace alidade {
namespace {

constexpr Checkerboard kObservedBoard = {.columns = 5, .rows = 4, .square_m = 0.1};

AnyCamera pinhole() {
  return AnyCamera::make("pinhole", std::vector<double>{500, 500, 320, 240});
}

TEST(ExactView, PlacesCornersByTheirIds) {
  const View view = exactView(pinhole(), kVga, kObservedBoard, {{}, {-0.2, -0.1, 1}}, "a.png");
  EXPECT_EQ(view.image, "a.png");
  EXPECT_EQ(view.size, kVga);
  ASSERT_EQ(view.corners.size(), 20U);
  for (int id = 0; id < 20; ++id) {
    const Corner& corner = view.corners[static_cast<std::size_t>(id)];
    EXPECT_EQ(corner.id, id);
    EXPECT_NEAR(corner.pixel.x(), 220 + 50 * (id % 5), 1e-9);
    EXPECT_NEAR(corner.pixel.y(), 190 + 50 * (id / 5), 1e-9);
    EXPECT_TRUE(std::isnan(corner.sigma_px));
  }
}

// By the midpoint rule on rings of equal area, each place weighted with what it takes of the image.
Eigen::Vector2d integratedCentroid(const AnyCamera& camera, const SE3& pose, const Eigen::Vector3d& middle,
                                   double radius) {
  constexpr int kRings = 100;
  constexpr int kSteps = 60;
  constexpr double kStep = 1e-6;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double area = 0;
  const auto seen = [&](double x, double y) {
    return camera.project(pose * (middle + Eigen::Vector3d(x, y, 0))).pixel;
  };
  for (int ring = 0; ring < kRings; ++ring) {
    for (int step = 0; step < kSteps; ++step) {
      const double r = radius * std::sqrt((ring + 0.5) / kRings);
      const double angle = 2 * std::numbers::pi * step / kSteps;
      const double x = r * std::cos(angle);
      const double y = r * std::sin(angle);
      const Eigen::Vector2d dx = (seen(x + kStep, y) - seen(x - kStep, y)) / (2 * kStep);
      const Eigen::Vector2d dy = (seen(x, y + kStep) - seen(x, y - kStep)) / (2 * kStep);
      const double weight = std::abs(dx.x() * dy.y() - dx.y() * dy.x());
      sum += weight * seen(x, y);
      area += weight;
    }
  }
  return sum / area;
}

TEST(ExactView, PlacesCirclesAtTheCentroidsOfTheirImages) {
  const Board board = CircleGrid{.columns = 4, .rows = 3, .spacing_m = 0.1, .diameter_m = 0.08};
  const AnyCamera camera =
      AnyCamera::make("kannala_brandt", std::vector<double>{300, 300, 320, 240, 0.02, -0.01, 0, 0});
  const SE3 pose{SO3::exp({0.5, 0.6, 0.1}), {-0.05, -0.1, 0.25}};
  const View view = exactView(camera, kVga, board, pose, "");
  ASSERT_GE(view.corners.size(), 8U);
  double most_off_middle = 0;
  for (const Corner& corner : view.corners) {
    const Eigen::Vector3d& middle = board.corner(corner.id);
    const Eigen::Vector2d truth = integratedCentroid(camera, pose, middle, board.discRadius());
    EXPECT_LT((corner.pixel - truth).norm(), 1e-3);
    most_off_middle = std::max(most_off_middle, (camera.project(pose * middle).pixel - truth).norm());
  }
  EXPECT_GT(most_off_middle, 1);
}

TEST(ExactView, LeavesOutCirclesThatAreCut) {
  const Board board = CircleGrid{.columns = 3, .rows = 3, .spacing_m = 0.1, .diameter_m = 0.08};
  // The middles of the first column are at pixel 10 and their radius is 20.
  const View view = exactView(pinhole(), kVga, board, {{}, {-0.62, -0.1, 1}}, "");
  EXPECT_EQ(view.corners.size(), 6U);
}

TEST(ExactView, LeavesOutCornersOutsideTheImage) {
  // Numbers that no order of rounding changes. Corner columns at -0.5 - 64, -0.5, 63.5, ...: the second lies
  // on the image's border, which belongs to it.
  const AnyCamera camera = AnyCamera::make("pinhole", std::vector<double>{512, 512, 320, 240});
  Checkerboard board = kObservedBoard;
  board.square_m = 0.125;
  const View view = exactView(camera, kVga, board, {{}, {(-0.5 - 64 - 320) / 512, 0, 1}}, "");
  ASSERT_EQ(view.corners.size(), 16U);
  EXPECT_EQ(view.corners[0].id, 1);
  EXPECT_EQ(view.corners[4].id, 6);
  // The border on the right does not.
  EXPECT_EQ(exactView(camera, kVga, board, {{}, {(639.5 - 320) / 512, 0, 1}}, "").corners.size(), 0U);
  EXPECT_EQ(exactView(pinhole(), kVga, kObservedBoard, {{}, {0, 0, -1}}, "").corners.size(), 0U);
}

TEST(ExactView, ShowsNothingFromBehind) {
  const auto turned = SO3::exp({0, std::numbers::pi, 0});
  EXPECT_FALSE(seesPrintedSide({turned, {0, 0, 1}}));
  EXPECT_TRUE(exactView(pinhole(), kVga, kObservedBoard, {turned, {0, 0, 1}}, "").corners.empty());
}

TEST(CornerNoise, HasTheAskedForSpread) {
  constexpr double kSigma = 0.3;
  Random random(5);
  const View exact = exactView(pinhole(), kVga, kObservedBoard, {{}, {-0.2, -0.1, 1}}, "");
  double sum = 0;
  double sum2 = 0;
  int num_values = 0;
  for (int i = 0; i < 1000; ++i) {
    View view = exact;
    addCornerNoise(view, kSigma, random);
    for (std::size_t k = 0; k < view.corners.size(); ++k) {
      ASSERT_EQ(view.corners[k].sigma_px, kSigma);
      for (const double d : {view.corners[k].pixel.x() - exact.corners[k].pixel.x(),
                             view.corners[k].pixel.y() - exact.corners[k].pixel.y()}) {
        sum += d;
        sum2 += d * d;
        ++num_values;
      }
    }
  }
  ASSERT_EQ(num_values, 40000);
  // Five standard errors of each.
  EXPECT_NEAR(sum / num_values, 0, 5 * kSigma / std::sqrt(num_values));
  EXPECT_NEAR(std::sqrt(sum2 / num_values), kSigma, 5 * kSigma / std::sqrt(2.0 * num_values));
}

TEST(CornerNoise, RefusesWhatIsNoSigma) {
  Random random(5);
  View view;
  for (const double sigma :
       {-1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    EXPECT_THROW(addCornerNoise(view, sigma, random), Error) << sigma;
  }
}

}  // namespace
}  // namespace alidade
