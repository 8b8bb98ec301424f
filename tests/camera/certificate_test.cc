// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include "alidade/camera/any_camera.h"
#include "support/model_fixture.h"

namespace alidade {
namespace {

constexpr double kAngleTolerance = 1e-4;  // rad; the certificate keeps 1e-5 away from the fold on purpose

// The first angle at which the distortion's determinant turns negative, by dense sampling in the plane and
// nothing else: another way to the answer than the certificate's.
double bruteForceFold(const Camera<Radtan>& camera) {
  double first = std::numbers::pi;
  constexpr int kNumAzimuths = 360;
  for (int a = 0; a < kNumAzimuths; ++a) {
    const double azimuth = 2 * std::numbers::pi * a / kNumAzimuths;
    for (double angle = 0; angle < std::min(first, kPerspectiveMaxAngle); angle += 4e-5) {
      Eigen::Matrix<double, 2, 3, Eigen::RowMajor> J;
      double px[2];
      const Eigen::Vector3d ray = rayAt(angle, azimuth) / std::cos(angle);  // on the plane z = 1
      if (!projectFormulaJacobian<Radtan>(camera.params().data(), ray.data(), px, J.data(), nullptr)) break;
      if (J(0, 0) * J(1, 1) - J(0, 1) * J(1, 0) <= 0) {
        first = angle;
        break;
      }
    }
  }
  return first;
}

TEST(Certificate, AgreesWithBruteForce) {
  int num_with_fold = 0;
  for (const auto& params : ModelFixture<Radtan>::paramSets()) {
    const Camera<Radtan> camera(params);
    const double fold = bruteForceFold(camera);
    if (fold > kPerspectiveMaxAngle) {
      EXPECT_FALSE(camera.cone().is_limited_by_fold);
      EXPECT_EQ(camera.cone().max_angle_rad, kPerspectiveMaxAngle);
      continue;
    }
    ++num_with_fold;
    EXPECT_TRUE(camera.cone().is_limited_by_fold);
    EXPECT_NEAR(camera.cone().max_angle_rad, fold, kAngleTolerance);
    EXPECT_LT(camera.cone().max_angle_rad, fold);
  }
  EXPECT_EQ(num_with_fold, 3);
}

TEST(Certificate, FindsTheFoldOfASingleCoefficientExactly) {
  // r (1 + k r^2) turns at r^2 = -1 / (3 k).
  int num_checked = 0;
  for (const double k1 : {-0.01, -0.1, -0.3, -1.0, -10.0}) {
    const Camera<Radtan> camera({1000, 1000, 500, 500, k1, 0, 0, 0, 0});
    EXPECT_NEAR(camera.cone().max_angle_rad, std::atan(std::sqrt(-1 / (3 * k1))) - kFoldMargin, 1e-9);
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 5);
}

TEST(Certificate, SeesANarrowDipBetweenSamples) {
  // g(r) = r (1 + k1 r^2 + k2 r^4) has g' = 1 + 3 k1 s + 5 k2 s^2 with s = r^2. Choosing the two roots in s
  // to lie 1e-4 apart gives a fold that reopens at once.
  const double s0 = 0.36;
  const double s1 = s0 + 1e-4;
  const double k2 = 1 / (5 * s0 * s1);
  const double k1 = -(s0 + s1) / (3 * s0 * s1);
  const Camera<Radtan> camera({1000, 1000, 500, 500, k1, k2, 0, 0, 0});
  EXPECT_TRUE(camera.cone().is_limited_by_fold);
  EXPECT_NEAR(camera.cone().max_angle_rad, std::atan(std::sqrt(s0)), kAngleTolerance);
}

TEST(Certificate, RefusesTheRaysThatOtherLibrariesFoldIntoTheImage) {
  // With these parameters the bare polynomial puts rays at 65 to 69 degrees back inside the 1920x1200 image.
  const Camera<Radtan> camera({1003, 1003, 959.5, 599.5, -0.28, 0.08, 5e-4, -4e-4, -0.01});
  int num_folded_in = 0;
  for (double deg = 60; deg < 89; deg += 0.05) {
    for (int a = 0; a < 36; ++a) {
      const Eigen::Vector3d ray = rayAt(deg * std::numbers::pi / 180, a * std::numbers::pi / 18);
      double px[2];
      ASSERT_TRUE(projectFormula<Radtan>(camera.params().data(), ray.data(), px));
      const bool is_in_image = px[0] > -0.5 && px[0] < 1919.5 && px[1] > -0.5 && px[1] < 1199.5;
      const Projection projection = camera.project(ray);
      if (deg * std::numbers::pi / 180 > camera.cone().max_angle_rad) {
        EXPECT_EQ(projection.status, ProjectStatus::kOutside);
        num_folded_in += is_in_image ? 1 : 0;
      }
    }
  }
  EXPECT_GT(num_folded_in, 100) << "the trap that this test is about";
}

TEST(CertifyDomain, TellsWhetherEveryPixelHasARay) {
  const ImageSize size{.width = 640, .height = 480};
  const std::vector<double> good = {535, 534, 320, 240, -0.28, 0.08, 0, 0, 0};
  const DomainCertificate whole = certifyDomain(AnyCamera::make("radtan", good), size);
  EXPECT_TRUE(whole.full_image);
  EXPECT_FALSE(whole.pixel_without_ray);
  EXPECT_GT(whole.min_relative_det, 0.2);

  // A fold at 45 degrees maps to a radius of 2/3 f = 357 px, short of the corners at 400 px.
  const std::vector<double> folded = {535, 535, 319.5, 239.5, -1.0 / 3, 0, 0, 0, 0};
  const DomainCertificate part = certifyDomain(AnyCamera::make("radtan", folded), size);
  EXPECT_FALSE(part.full_image);
  ASSERT_TRUE(part.pixel_without_ray);
  EXPECT_GT((*part.pixel_without_ray - Eigen::Vector2d(319.5, 239.5)).norm(), 2.0 / 3 * 535 - 1e-2);
  EXPECT_EQ(part.min_relative_det, 0.0);
}

}  // namespace
}  // namespace alidade
