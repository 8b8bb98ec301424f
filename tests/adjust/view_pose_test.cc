// SPDX-License-Identifier: MIT
#include "alidade/adjust/board/view_pose.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "support/image_sizes.h"
#include "support/simulated_set.h"
#include "support/user_views.h"

namespace alidade {
namespace {

double poseError(const SE3& a, const SE3& b) {
  return (a.inverse() * b).log().norm();
}

TEST(PoseFromCorners, IsExactForEveryLensAlsoBeyond90Degrees) {
  int num_checked = 0;
  int num_behind = 0;
  for (const auto& [model, fov_deg] :
       {std::pair("pinhole", 20.0), std::pair("radtan", 60.0), std::pair("rational", 100.0),
        std::pair("kannala_brandt", 200.0), std::pair("double_sphere", 200.0), std::pair("omni", 180.0)}) {
    Random random(7);
    const DrawnCamera drawn = drawCamera(model, fov_deg, random);
    const UserSet set = drawUserViews(drawn, 20, 0.0, random);
    for (std::size_t v = 0; v < set.views.size(); ++v) {
      const auto pose = poseFromCorners(drawn.camera, observationsOf(set.board, set.views[v]));
      ASSERT_TRUE(pose) << model << " " << v;
      EXPECT_LE(poseError(*pose, set.poses[v]), 1e-7) << model << " " << v;
      for (const Corner& corner : set.views[v].corners)
        num_behind += (set.poses[v] * set.board.corner(corner.id)).z() < 0 ? 1 : 0;
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 120);
  EXPECT_GE(num_behind, 50) << "corners behind the camera's plane are among them";
}

// What the homography to the plane z = 1 gave on these very views, median over 200: 0.30 px.
TEST(PoseFromCorners, LeavesLittleMoreThanTheNoise) {
  constexpr double kNoisePx = 0.1;
  constexpr double kMedianPx = 0.22;  // of the RMS; the noise alone is 0.14
  const SimulatedSet set = simulateSet(AnyCamera::make("pinhole", std::vector<double>{3600, 3600, 640, 480}),
                                       kQuadVga, 200, kNoisePx, 3, {.min_fill = 0.15});
  std::vector<double> rms;
  for (const View& view : set.views) {
    const auto pose = poseFromCorners(set.camera, observationsOf(set.board, view));
    ASSERT_TRUE(pose);
    double sum = 0;
    for (const Corner& corner : view.corners)
      sum += (set.camera.project(*pose * set.board.corner(corner.id)).pixel - corner.pixel).squaredNorm();
    rms.push_back(std::sqrt(sum / static_cast<double>(view.corners.size())));
  }
  std::sort(rms.begin(), rms.end());
  ASSERT_EQ(rms.size(), 200U);
  EXPECT_LE(rms[100], kMedianPx);
}

TEST(PoseFromRays, RefusesWhatDeterminesNoPose) {
  std::vector<Eigen::Vector2d> line;
  std::vector<Eigen::Vector3d> rays;
  for (int i = 0; i < 10; ++i) {
    line.emplace_back(0.01 * i, 0.02 * i);
    rays.push_back(Eigen::Vector3d(0.01 * i, 0.02 * i, 1).normalized());
  }
  EXPECT_FALSE(poseFromRays(line, rays));
  EXPECT_FALSE(poseFromRays(std::span(line).first(3), std::span(rays).first(3)));
  const std::vector<Eigen::Vector2d> same(6, Eigen::Vector2d(0.1, 0.2));
  EXPECT_FALSE(poseFromRays(same, std::span(rays).first(6)));
  EXPECT_FALSE(poseFromRays({}, {}));
}

TEST(PoseFromRays, PutsPointsOnTheirRaysAndNotBehind) {
  // The same lines with their rays turned round see the board on the other side of the camera.
  const Board board = Checkerboard{.columns = 5, .rows = 4, .square_m = 0.05};
  SE3 truth;
  truth.rotation = SO3::exp({0.3, -0.4, 0.2});
  truth.translation = {-0.1, 0.05, 0.6};
  std::vector<Eigen::Vector2d> points;
  std::vector<Eigen::Vector3d> rays;
  std::vector<Eigen::Vector3d> turned;
  for (const Eigen::Vector3d& p : board.corners()) {
    points.emplace_back(p.head<2>());
    rays.push_back((truth * p).normalized());
    turned.push_back(-rays.back());
  }
  const auto pose = poseFromRays(points, rays);
  const auto behind = poseFromRays(points, turned);
  ASSERT_TRUE(pose && behind);
  EXPECT_LE(poseError(*pose, truth), 1e-9);
  EXPECT_LE((behind->translation + truth.translation).norm(), 1e-9);
  turned[3] = rays[3];
  EXPECT_FALSE(poseFromRays(points, turned)) << "one point would lie behind its ray";
}

TEST(MirroredTilt, KeepsTheMiddleAndItsTwiceIsTheSame) {
  SE3 pose;
  pose.rotation = SO3::exp({0.3, -0.4, 0.2});
  pose.translation = {-0.1, 0.05, 0.6};
  const Eigen::Vector3d middle(0.1, 0.05, 0);
  const SE3 other = mirroredTilt(pose, middle);
  EXPECT_LE((other * middle - pose * middle).norm(), 1e-12);
  EXPECT_GE(poseError(other, pose), 0.1);
  EXPECT_LE(poseError(mirroredTilt(other, middle), pose), 1e-9);
}

}  // namespace
}  // namespace alidade
