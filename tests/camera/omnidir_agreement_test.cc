// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <opencv2/ccalib/omnidir.hpp>

#include "alidade/core/random.h"
#include "support/model_fixture.h"

namespace alidade {
namespace {

constexpr double kTolerance = 1e-9;  // px; both evaluate the same formula in double
constexpr int kNumPoints = 2000;     // of each set
// Farther out, towards a pole behind the camera, theirs subtracts nearly equal numbers; px.
constexpr double kFar = 1e4;

// Rays all over the domain, those behind the camera's plane too.
TEST(OmnidirAgreement, OmniProjectsAlikeInsideTheDomain) {
  int num_checked = 0;
  int num_behind = 0;
  int num_with_large_xi = 0;
  for (const auto& p : ModelFixture<Omni>::paramSets()) {
    const Camera<Omni> camera(p);
    Random random(3);
    std::vector<cv::Vec3d> points;
    for (int i = 0; i < kNumPoints; ++i) {
      const Eigen::Vector3d ray =
          random.uniform(0.5, 20.0) *
          rayAt(camera.cone().max_angle_rad * random.uniform(), random.uniform(0, 2 * std::numbers::pi));
      points.emplace_back(ray.x(), ray.y(), ray.z());
    }
    const double skew = 0;
    const cv::Matx33d K(p[0], skew, p[2], 0, p[1], p[3], 0, 0, 1);
    const cv::Vec4d distortion(p[5], p[6], p[7], p[8]);
    std::vector<cv::Vec2d> pixels;
    cv::omnidir::projectPoints(points, pixels, cv::Vec3d::all(0), cv::Vec3d::all(0), K, p[4], distortion);
    ASSERT_EQ(pixels.size(), points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Projection projection = camera.project({points[i][0], points[i][1], points[i][2]});
      ASSERT_TRUE(projection.ok());
      if (std::max(std::abs(pixels[i][0]), std::abs(pixels[i][1])) > kFar) continue;
      ASSERT_NEAR(projection.pixel.x(), pixels[i][0], kTolerance);
      ASSERT_NEAR(projection.pixel.y(), pixels[i][1], kTolerance);
      num_behind += points[i][2] < 0 ? 1 : 0;
      ++num_checked;
    }
    num_with_large_xi += p[4] > 1 ? 1 : 0;
  }
  EXPECT_GE(num_checked, 6 * kNumPoints * 9 / 10);
  EXPECT_GE(num_behind, kNumPoints / 2);
  EXPECT_EQ(num_with_large_xi, 2);
}

}  // namespace
}  // namespace alidade
