// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>

#include "alidade/core/random.h"
#include "support/model_fixture.h"

namespace alidade {
namespace {

constexpr double kTolerance = 1e-9;  // px; both evaluate the same formula in double
constexpr int kNumPoints = 1000;     // of each set

// Projects points inside the domain and in front of the camera with ours and theirs.
template <class M, class Theirs>
void compare(const Theirs& theirs, int expected_num_checked) {
  int num_checked = 0;
  for (const auto& p : ModelFixture<M>::paramSets()) {
    const Camera<M> camera(p);
    const double max_angle = std::min(camera.cone().max_angle_rad, 1.2);
    Random random(3);
    std::vector<cv::Point3d> points;
    for (int i = 0; i < kNumPoints; ++i) {
      const Eigen::Vector3d ray = random.uniform(0.5, 20.0) * rayAt(max_angle * random.uniform(),
                                                                    random.uniform(0, 2 * std::numbers::pi));
      points.emplace_back(ray.x(), ray.y(), ray.z());
    }
    const cv::Matx33d K(p[0], 0, p[2], 0, p[1], p[3], 0, 0, 1);
    const std::vector<double> distortion(p.begin() + 4, p.end());
    std::vector<cv::Point2d> pixels;
    theirs(points, K, distortion, pixels);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Projection projection = camera.project({points[i].x, points[i].y, points[i].z});
      ASSERT_TRUE(projection.ok());
      const double scale = 1 + std::abs(pixels[i].x) / 1e4 + std::abs(pixels[i].y) / 1e4;
      EXPECT_NEAR(projection.pixel.x(), pixels[i].x, kTolerance * scale);
      EXPECT_NEAR(projection.pixel.y(), pixels[i].y, kTolerance * scale);
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, expected_num_checked);
}

void projectPerspective(const std::vector<cv::Point3d>& points, const cv::Matx33d& K,
                        const std::vector<double>& distortion, std::vector<cv::Point2d>& pixels) {
  cv::projectPoints(points, cv::Vec3d::zeros(), cv::Vec3d::zeros(), K, distortion, pixels);
}

TEST(OpenCvAgreement, RadtanProjectsAlikeInsideTheDomain) {
  compare<Radtan>(projectPerspective, 6000);
}

TEST(OpenCvAgreement, RationalProjectsAlikeInsideTheDomain) {
  compare<Rational>(projectPerspective, 7000);
}

TEST(OpenCvAgreement, ThinPrismProjectsAlikeInsideTheDomain) {
  compare<ThinPrism>(projectPerspective, 5000);
}

TEST(OpenCvAgreement, TiltedProjectsAlikeInsideTheDomain) {
  compare<Tilted>(projectPerspective, 5000);
}

void projectFisheye(const std::vector<cv::Point3d>& points, const cv::Matx33d& K,
                    const std::vector<double>& distortion, std::vector<cv::Point2d>& pixels) {
  const std::vector<double> k(distortion.begin(), distortion.begin() + 4);
  const double skew = distortion.size() > 4 ? distortion[4] : 0;
  cv::fisheye::projectPoints(points, pixels, cv::Vec3d::zeros(), cv::Vec3d::zeros(), K, k, skew);
}

TEST(OpenCvAgreement, KannalaBrandtProjectsAlikeInsideTheDomain) {
  compare<KannalaBrandt>(projectFisheye, 5000);
}

TEST(OpenCvAgreement, KannalaBrandtSkewProjectsAlikeInsideTheDomain) {
  compare<KannalaBrandtSkew>(projectFisheye, 3000);
}

}  // namespace
}  // namespace alidade
