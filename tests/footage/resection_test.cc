// SPDX-License-Identifier: MIT
#include "alidade/footage/geometry/resection.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "footage/points_scene.h"

namespace alidade {
namespace {

using testing::footageCameras;
using testing::noisy;
using testing::randomDirection;
using testing::ScatteredPoints;
using testing::scatteredPoints;

double distance(const SE3& a, const SE3& b) {
  return (a.inverse() * b).log().norm();
}

TEST(Resection, TruePoseIsAmongTheThreePointPoses) {
  constexpr int kCases = 500;
  Random random(21);
  int num_found = 0;
  int num_exact = 0;  // poses that do see the points along the rays
  int num_poses = 0;
  for (int i = 0; i < kCases; ++i) {
    const SE3 truth{SO3::exp(random.uniform(0, 2) * randomDirection(random)), 2 * randomDirection(random)};
    std::array<Eigen::Vector3d, 3> points;
    std::array<Eigen::Vector3d, 3> rays;
    for (std::size_t k = 0; k < 3; ++k) {
      const Eigen::Vector3d in_camera = random.uniform(1, 6) * randomDirection(random);  // also behind
      points[k] = truth.inverse() * in_camera;
      rays[k] = in_camera.normalized();
    }
    double nearest = 1;
    for (const SE3& pose : threePointPoses(points, rays)) {
      nearest = std::min(nearest, distance(pose, truth));
      ++num_poses;
      double worst = 0;
      for (std::size_t k = 0; k < 3; ++k)
        worst = std::max(worst, ((pose * points[k]).normalized() - rays[k]).norm());
      num_exact += worst < 1e-4 ? 1 : 0;
    }
    num_found += nearest < 1e-5 ? 1 : 0;
  }
  EXPECT_GE(num_found, 0.98 * kCases);  // rounding: some samples are all but degenerate
  EXPECT_GE(num_poses, num_found);
  EXPECT_GE(num_exact, 0.95 * num_poses);
}

// Points in the world of a camera, a share of whose pixels are anywhere.
std::vector<KnownPoint> knownPoints(const AnyCamera& camera, const SE3& camera_from_world, double false_share,
                                    double noise_px, Random& random) {
  std::vector<KnownPoint> known;
  const ScatteredPoints scattered = scatteredPoints(camera, 200, random);
  for (std::size_t i = 0; i < scattered.points.size(); ++i) {
    const Eigen::Vector3d in_world = camera_from_world.inverse() * scattered.points[i];
    KnownPoint point{.point = in_world.homogeneous().normalized(),
                     .pixel = noisy(scattered.pixels[i], noise_px, random),
                     .sigma_px = noise_px};
    if (random.uniform() < false_share) point.pixel = {random.uniform(0, 639), random.uniform(0, 479)};
    known.push_back(point);
  }
  return known;
}

TEST(Resection, PoseIsFoundWithoutAGuessAmongFalsePoints) {
  int num_cases = 0;
  for (const AnyCamera& camera : footageCameras()) {
    SCOPED_TRACE(camera.modelId());
    Random random(22);
    for (int i = 0; i < 10; ++i) {
      const SE3 truth{SO3::exp(random.uniform(0, 1) * randomDirection(random)), randomDirection(random)};
      const auto known = knownPoints(camera, truth, 0.4, 0.3, random);
      const auto found = resect(camera, known, std::nullopt, 2, 7);
      ASSERT_TRUE(found);
      EXPECT_LT(distance(found->camera_from_world, truth), 0.01);
      const auto marked = std::count(found->is_inlier.begin(), found->is_inlier.end(), true);
      EXPECT_EQ(static_cast<std::size_t>(marked), found->num_inliers);
      EXPECT_GT(found->num_inliers, 90U);  // of about 120
      EXPECT_LT(found->num_inliers, 150U);
      ++num_cases;
    }
  }
  EXPECT_EQ(num_cases, 40);
}

TEST(Resection, GuessIsRefinedAndAWrongOneDoesNotMatter) {
  const AnyCamera camera = footageCameras()[2];
  Random random(23);
  const SE3 truth{SO3::exp(Eigen::Vector3d(0.2, -0.3, 0.1)), Eigen::Vector3d(0.5, -0.2, 0.3)};
  const auto known = knownPoints(camera, truth, 0.1, 0.1, random);
  const SE3 near =
      truth * SE3::exp((Eigen::Matrix<double, 6, 1>() << 0.05, 0, 0.05, 0.02, -0.02, 0).finished());
  const SE3 wrong{SO3::exp(Eigen::Vector3d(0, 2.5, 0)), Eigen::Vector3d(3, 0, 0)};
  for (const SE3& guess : {near, wrong}) {
    const auto found = resect(camera, known, guess, 2, 7);
    ASSERT_TRUE(found);
    EXPECT_LT(distance(found->camera_from_world, truth), 0.003);
  }
}

TEST(Resection, FewOrContradictoryPointsHaveNoPose) {
  const AnyCamera camera = footageCameras()[0];
  Random random(24);
  const auto known = knownPoints(camera, SE3(), 0, 0.1, random);
  EXPECT_FALSE(resect(camera, std::span(known).first(7), SE3(), 2, 7));
  EXPECT_TRUE(resect(camera, std::span(known).first(20), SE3(), 2, 7));
  const auto false_points = knownPoints(camera, SE3(), 1, 0.1, random);
  const auto found = resect(camera, false_points, std::nullopt, 2, 7);
  EXPECT_TRUE(!found || found->num_inliers < 20);
}

}  // namespace
}  // namespace alidade
