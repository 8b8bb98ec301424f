// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include "alidade/init/closed_form_intrinsics.h"
#include "alidade/init/homography.h"
#include "alidade/init/pose_from_homography.h"
#include "support/simulated_set.h"

namespace alidade {
namespace {

constexpr ImageSize kSize{.width = 1280, .height = 960};

std::vector<Eigen::Matrix3d> homographiesOf(const SimulatedSet& set) {
  std::vector<Eigen::Matrix3d> all;
  for (const View& view : set.views) {
    std::vector<Eigen::Vector2d> from;
    std::vector<Eigen::Vector2d> to;
    for (const Corner& corner : view.corners) {
      from.emplace_back(set.board.corner(corner.id).head<2>());
      to.push_back(corner.pixel);
    }
    const auto H = fitHomography(from, to);
    if (H) all.push_back(*H);
  }
  return all;
}

TEST(FitHomography, RecoversAKnownOne) {
  Random random(1);
  int num_checked = 0;
  for (int k = 0; k < 200; ++k) {
    Eigen::Matrix3d H;
    H << 500 + 100 * random.normal(), 50 * random.normal(), 600,  //
        50 * random.normal(), 500 + 100 * random.normal(), 400,   //
        0.3 * random.normal(), 0.3 * random.normal(), 1;
    std::vector<Eigen::Vector2d> from;
    std::vector<Eigen::Vector2d> to;
    for (int i = 0; i < 20; ++i) {
      from.emplace_back(random.uniform(0, 0.5), random.uniform(0, 0.5));
      to.emplace_back((H * from.back().homogeneous()).hnormalized());
    }
    const auto fitted = fitHomography(from, to);
    ASSERT_TRUE(fitted);
    const Eigen::Matrix3d scaled =
        *fitted * (H.norm() / fitted->norm()) * ((*fitted)(2, 2) * H(2, 2) < 0 ? -1 : 1);
    EXPECT_LE((scaled - H).norm(), 1e-7 * H.norm());
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 200);
}

TEST(FitHomography, RefusesPointsThatDetermineNone) {
  std::vector<Eigen::Vector2d> line;
  for (int i = 0; i < 10; ++i) line.emplace_back(i, 2 * i);
  EXPECT_FALSE(fitHomography(line, line));
  const std::vector<Eigen::Vector2d> three = {{0, 0}, {1, 0}, {0, 1}};
  EXPECT_FALSE(fitHomography(three, three));
  const std::vector<Eigen::Vector2d> same(6, Eigen::Vector2d(3, 4));
  EXPECT_FALSE(fitHomography(same, same));
}

TEST(ZhangIntrinsics, AreExactWithoutDistortionAndNoise) {
  const std::vector<double> truth = {1003, 1011, 655, 470};
  const SimulatedSet set = simulateSet(AnyCamera::make("pinhole", truth), kSize, 8, 0, 2);
  const auto start = zhangIntrinsics(homographiesOf(set), kSize);
  ASSERT_TRUE(start);
  EXPECT_NEAR(start->fx, truth[0], 1e-4);
  EXPECT_NEAR(start->fy, truth[1], 1e-4);
  EXPECT_NEAR(start->cx, truth[2], 1e-4);
  EXPECT_NEAR(start->cy, truth[3], 1e-4);
}

TEST(ZhangIntrinsics, RefuseViewsThatDetermineNoCamera) {
  const AnyCamera camera = AnyCamera::make("pinhole", std::vector<double>{1000, 1000, 639.5, 479.5});
  SimulatedSet set{.camera = camera,
                   .size = kSize,
                   .board = {.columns = 9, .rows = 6, .square_m = 0.025},
                   .poses = {},
                   .views = {}};
  for (int i = 0; i < 5; ++i) {
    SE3 pose;
    pose.translation = {-0.1, -0.06, 0.4 + 0.1 * i};
    set.views.push_back(exactView(camera, kSize, set.board, pose, "v"));
  }
  const auto homographies = homographiesOf(set);
  ASSERT_EQ(homographies.size(), 5U);
  const std::vector<Eigen::Matrix3d> two(homographies.begin(), homographies.begin() + 2);
  EXPECT_FALSE(zhangIntrinsics(two, kSize));
  EXPECT_GE(affineStarts(homographies, kSize).size(), 6U) << "the fields of view are always tried";
}

TEST(CentredFocal, IsExactForACentredCamera) {
  const std::vector<double> truth = {1003, 1003, 639.5, 479.5};
  const SimulatedSet set = simulateSet(AnyCamera::make("pinhole", truth), kSize, 3, 0, 3);
  const auto start = centredFocal(homographiesOf(set), kSize);
  ASSERT_TRUE(start);
  EXPECT_NEAR(start->fx, 1003, 1e-4);
  EXPECT_EQ(start->fx, start->fy);
}

TEST(PoseFromView, RecoversThePoseThroughAnyLens) {
  int num_checked = 0;
  for (const std::vector<double>& p :
       {std::vector<double>{1003, 1001, 645, 475, 0, 0, 0, 0, 0},
        std::vector<double>{603, 601, 645, 475, -0.15, 0.02, 1e-3, -1e-3, -0.001}}) {
    const SimulatedSet set = simulateSet(AnyCamera::make("radtan", p), kSize, 20, 0, 4);
    for (std::size_t v = 0; v < set.views.size(); ++v) {
      const auto pose = poseFromView(set.camera, set.board, set.views[v].corners);
      ASSERT_TRUE(pose);
      const SE3 off = set.poses[v].inverse() * *pose;
      EXPECT_LE(off.log().norm(), 1e-6);
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 40);
}

}  // namespace
}  // namespace alidade
