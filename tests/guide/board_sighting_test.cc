// SPDX-License-Identifier: MIT
#include "alidade/guide/coverage.h"

#include <cmath>
#include <vector>

#include <gmock/gmock.h>

#include "alidade/core/degrees.h"
#include "alidade/simulate/observe.h"
#include "alidade/target/board_turns.h"

namespace alidade {
namespace {

// So small that the lens shows all of it nearly alike.
constexpr Checkerboard kSmallBoard{.columns = 4, .rows = 3, .square_m = 0.004};

std::vector<AnyCamera> someCameras() {
  return {AnyCamera::make("pinhole", std::vector<double>{400, 410, 330, 235}),
          AnyCamera::make("radtan", std::vector<double>{530, 532, 325, 242, -0.25, 0.07, 1e-3, -5e-4, 0}),
          AnyCamera::make("kannala_brandt", std::vector<double>{230, 231, 318, 239, 0.02, -0.005, 1e-3, 0})};
}

// The board with its middle on a pixel's ray, as tiltedBoard() has it.
SE3 poseAt(const AnyCamera& camera, const Eigen::Vector2d& pixel, const BoardTilt& tilt) {
  const SO3 rotation = *squarePose(camera, pixel) * tiltedBoard(tilt);
  return {rotation, 0.3 * *camera.unproject(pixel) - rotation * kSmallBoard.middle()};
}

// Distance in the image between two corners given by column and row.
double spanOf(const AnyCamera& camera, const SE3& pose, int column_a, int row_a, int column_b, int row_b) {
  const auto pixel = [&](int column, int row) {
    return camera.project(pose * kSmallBoard.corner(row * kSmallBoard.columns + column)).pixel;
  };
  return (pixel(column_a, row_a) - pixel(column_b, row_b)).norm();
}

TEST(BoardSighting, SeesTheTiltThatTheBoardWasGiven) {
  int num_poses = 0;
  for (const AnyCamera& camera : someCameras()) {
    for (const double u : {40.0, 200.0, 320.0, 600.0}) {
      for (const double v : {30.0, 240.0, 450.0}) {
        for (const double right : {-40.0, 0.0, 20.0}) {
          for (const double lower : {-20.0, 0.0, 40.0}) {
            const BoardTilt tilt{.right_rad = kRadPerDeg * right, .lower_rad = kRadPerDeg * lower};
            const BoardSighting seen = sightBoard(camera, kSmallBoard, poseAt(camera, {u, v}, tilt));
            EXPECT_NEAR(seen.tilt.right_rad, tilt.right_rad, 1e-6);
            EXPECT_NEAR(seen.tilt.lower_rad, tilt.lower_rad, 1e-6);
            EXPECT_NEAR(seen.distance_m, 0.3, 1e-9);
            EXPECT_LT((seen.middle_px - Eigen::Vector2d(u, v)).norm(), 1e-6);
            ++num_poses;
          }
        }
      }
    }
  }
  EXPECT_EQ(num_poses, 3 * 12 * 9);
}

// What is said to be nearer must look larger, all over the image of every lens.
TEST(BoardSighting, CallsNearerWhatLooksLarger) {
  int num_poses = 0;
  for (const AnyCamera& camera : someCameras()) {
    for (const double u : {40.0, 200.0, 320.0, 600.0}) {
      for (const double v : {30.0, 240.0, 450.0}) {
        for (const double angle : {-40.0, -20.0, 20.0, 40.0}) {
          const BoardTilt across{.right_rad = kRadPerDeg * angle, .lower_rad = 0};
          const SE3 turned = poseAt(camera, {u, v}, across);
          EXPECT_EQ(spanOf(camera, turned, 3, 0, 3, 2) > spanOf(camera, turned, 0, 0, 0, 2), angle > 0)
              << camera.modelId() << " " << u << " " << v << " right " << angle;
          const BoardTilt along{.right_rad = 0, .lower_rad = kRadPerDeg * angle};
          const SE3 leaned = poseAt(camera, {u, v}, along);
          EXPECT_EQ(spanOf(camera, leaned, 0, 2, 3, 2) > spanOf(camera, leaned, 0, 0, 3, 0), angle > 0)
              << camera.modelId() << " " << u << " " << v << " lower " << angle;
          EXPECT_TRUE(seesPrintedSide(turned) && seesPrintedSide(leaned));
          num_poses += 2;
        }
      }
    }
  }
  EXPECT_EQ(num_poses, 3 * 12 * 8);
}

TEST(BoardSighting, TakesABoardParallelToAPinholesImageForSquare) {
  const AnyCamera camera = someCameras()[0];
  for (const double u : {0.0, 320.0, 639.0})
    EXPECT_LT((squarePose(camera, {u, 100.0})->matrix() - Eigen::Matrix3d::Identity()).norm(), 1e-4);
}

TEST(BoardSighting, TakesABoardThatFacesAFisheyeForSquare) {
  const AnyCamera camera =
      AnyCamera::make("kannala_brandt", std::vector<double>{200, 200, 320, 240, 0, 0, 0, 0});
  const Eigen::Vector2d pixel(560, 300);
  const Eigen::Vector3d n = *squarePose(camera, pixel) * Eigen::Vector3d::UnitZ();
  // The solid angle of a pixel goes as sin(t) / t, whose logarithm has the slope cot(t) - 1 / t.
  const Eigen::Vector3d ray = *camera.unproject(pixel);
  const double t = std::acos(ray.z());
  EXPECT_NEAR(std::acos(n.dot(ray)), std::atan((1 / t - 1 / std::tan(t)) / 3), 1e-4);
}

TEST(BoardSighting, NamesTilts) {
  const auto text = [](double right, double lower) {
    return tiltText({.right_rad = kRadPerDeg * right, .lower_rad = kRadPerDeg * lower});
  };
  EXPECT_EQ(text(-30, 0), "its left side turned 30 degrees towards the camera");
  EXPECT_EQ(text(0, 20), "its lower side turned 20 degrees towards the camera");
  EXPECT_EQ(text(40, -20),
            "its right side turned 40 degrees and its upper side 20 degrees towards the camera");
  EXPECT_EQ(text(3, -4), "not tilted");
}

}  // namespace
}  // namespace alidade
