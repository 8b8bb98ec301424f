// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>

#include "alidade/core/random.h"
#include "support/model_fixture.h"

namespace alidade {
namespace {

TEST(OpenCvAgreement, RadtanProjectsAlikeInsideTheDomain) {
  constexpr double kTolerance = 1e-9;  // px; both evaluate the same polynomial in double
  int num_checked = 0;
  for (const auto& p : ModelFixture<Radtan>::paramSets()) {
    const Camera<Radtan> camera(p);
    const double max_angle = std::min(camera.cone().max_angle_rad, 1.2);
    Random random(3);
    std::vector<cv::Point3d> points;
    for (int i = 0; i < 1000; ++i) {
      const Eigen::Vector3d ray = random.uniform(0.5, 20.0) * rayAt(max_angle * random.uniform(),
                                                                    random.uniform(0, 2 * std::numbers::pi));
      points.emplace_back(ray.x(), ray.y(), ray.z());
    }
    const cv::Matx33d K(p[0], 0, p[2], 0, p[1], p[3], 0, 0, 1);
    const std::vector<double> distortion(p.begin() + 4, p.end());
    std::vector<cv::Point2d> pixels;
    cv::projectPoints(points, cv::Vec3d::zeros(), cv::Vec3d::zeros(), K, distortion, pixels);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Projection projection = camera.project({points[i].x, points[i].y, points[i].z});
      ASSERT_TRUE(projection.ok());
      const double scale = 1 + std::abs(pixels[i].x) / 1e4 + std::abs(pixels[i].y) / 1e4;
      EXPECT_NEAR(projection.pixel.x(), pixels[i].x, kTolerance * scale);
      EXPECT_NEAR(projection.pixel.y(), pixels[i].y, kTolerance * scale);
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 6000);
}

}  // namespace
}  // namespace alidade
