// SPDX-License-Identifier: MIT
#include "alidade/camera/entrance_pupil.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "alidade/camera/batch.h"
#include "alidade/camera/camera_edit.h"
#include "alidade/camera/model_fit.h"
#include "alidade/camera/self_check.h"
#include "alidade/core/error.h"
#include "alidade/core/random.h"
#include "support/cameras_of_model.h"
#include "support/loop_variants.h"
#include "support/rays.h"

namespace alidade {
namespace {

constexpr EntrancePupil kPupil{.s1_m = 0.0021, .s2_m = -0.0004};

class EntrancePupilOf : public OfModel {};
INSTANTIATE_TEST_SUITE_P(Models, EntrancePupilOf, testing::ValuesIn(modelIds()), nameOfModel);

// A point at any distance along a ray from where the ray starts has the ray's pixel.
TEST_P(EntrancePupilOf, SeesAllPointsOfARay) {
  Random random(7);
  int num_checked = 0;
  for (const AnyCamera& central : cameras()) {
    const AnyCamera camera = central.withPupil(kPupil);
    for (int i = 0; i < 500; ++i) {
      const double angle = 0.98 * camera.cone().max_angle_rad * random.uniform();
      const Eigen::Vector3d ray = rayAt(angle, random.uniform(0, 2 * std::numbers::pi));
      const double s = angle * angle * (kPupil.s1_m + angle * angle * kPupil.s2_m);
      ASSERT_NEAR((camera.startOf(ray) - Eigen::Vector3d(0, 0, s)).norm(), 0, 1e-15);
      const Projection far = camera.project(ray);
      ASSERT_TRUE(far.ok());
      ASSERT_EQ(far.pixel, central.project(ray).pixel);
      for (const double distance_m : {0.08, 0.5, 30.0}) {
        const Projection near = camera.projectPoint(camera.startOf(ray) + distance_m * ray);
        // A point whose direction from the origin is beyond the domain may still be seen.
        ASSERT_TRUE(near.ok()) << angle << " " << distance_m;
        ASSERT_NEAR((near.pixel - far.pixel).norm(), 0, 1e-8 * (1 + far.pixel.norm())) << angle;
        ++num_checked;
      }
    }
  }
  EXPECT_EQ(num_checked, 1500 * static_cast<int>(cameras().size()));
}

TEST_P(EntrancePupilOf, HasTheDerivativesOfNearPoints) {
  constexpr double kStep = 1e-7;
  Random random(8);
  const AnyCamera camera = cameras().front().withPupil(kPupil);
  int num_checked = 0;
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d p =
        random.uniform(0.1, 0.6) *
        rayAt(0.8 * camera.cone().max_angle_rad * random.uniform(), 6.2 * random.uniform());
    Eigen::Matrix<double, 2, 3, Eigen::RowMajor> J;
    if (!camera.projectPoint(p, J.data()).ok()) continue;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(k);
      const Projection above = camera.projectPoint(p + step);
      const Projection below = camera.projectPoint(p - step);
      ASSERT_TRUE(above.ok() && below.ok());
      const Eigen::Vector2d slope = (above.pixel - below.pixel) / (2 * kStep);
      ASSERT_NEAR((J.col(k) - slope).norm(), 0, 1e-5 * (1 + slope.norm()));
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 600);
}

TEST_P(EntrancePupilOf, IsTheSameInBatches) {
  constexpr std::size_t kNum = 1001;
  Random random(9);
  const AnyCamera camera = cameras().front().withPupil(kPupil);
  std::vector<Eigen::Vector3d> points;
  for (std::size_t i = 0; i < kNum; ++i)
    points.push_back(random.uniform(0.02, 2) *
                     rayAt(1.1 * camera.cone().max_angle_rad * random.uniform(), 6.2 * random.uniform()));
  points[17] = {0, 0, 0.3};
  withAndWithoutAvx2([&] {
    std::vector<Projection> all(kNum);
    projectBatch(camera, points, all);
    int num_seen = 0;
    for (std::size_t i = 0; i < kNum; ++i) {
      const Projection one = camera.projectPoint(points[i]);
      ASSERT_EQ(all[i].status, one.status) << i;
      if (!one.ok()) continue;
      ASSERT_NEAR((all[i].pixel - one.pixel).norm(), 0, 1e-10 * (1 + one.pixel.norm())) << i;
      ++num_seen;
    }
    EXPECT_GT(num_seen, 700);
  });
}

TEST(EntrancePupil, IsKeptByEditsAndOtherModels) {
  const ImageSize size{.width = 640, .height = 480};
  const AnyCamera camera =
      AnyCamera::make("kannala_brandt", std::vector<double>{200, 201, 320, 240, 0.01, 0, 0, 0})
          .withPupil(kPupil);
  EXPECT_EQ(cropCamera(camera, size, {.x = 10, .y = 20, .width = 300, .height = 200}).camera.pupil(), kPupil);
  EXPECT_EQ(resizeCamera(camera, size, {.width = 320, .height = 240}).camera.pupil(), kPupil);
  EXPECT_EQ(rotateCamera(camera, size, 1).camera.pupil(), kPupil);
  EXPECT_EQ(fitModel(camera, size, "double_sphere").camera.pupil(), kPupil);
}

// A reader that ignores the pupil fails the check.
TEST(EntrancePupil, IsInTheSelfCheck) {
  const ImageSize size{.width = 640, .height = 480};
  const AnyCamera central =
      AnyCamera::make("kannala_brandt", std::vector<double>{200, 201, 320, 240, 0.01, 0, 0, 0});
  const AnyCamera camera = central.withPupil(kPupil);
  const std::vector<SelfCheckPoint> points = makeSelfCheck(camera, size);
  ASSERT_EQ(points.size(), 9U);
  EXPECT_TRUE(runSelfCheck(camera, size, points).isPassed());
  EXPECT_GT(runSelfCheck(central, size, points).worst_px, 0.05);
}

TEST(EntrancePupil, RefusesWhatNoLensHas) {
  EXPECT_THROW((EntrancePupil{.s1_m = 1}.validate()), Error);
  EXPECT_THROW((EntrancePupil{.s2_m = std::nan("")}.validate()), Error);
  EXPECT_NO_THROW((EntrancePupil{.s1_m = -0.02}.validate()));
}

// So near that two rays may meet it, a point has no pixel.
TEST(EntrancePupil, LeavesOutPointsInsideTheLens) {
  const AnyCamera camera =
      AnyCamera::make("kannala_brandt", std::vector<double>{200, 201, 320, 240, 0, 0, 0, 0})
          .withPupil({.s1_m = 0.01});
  EXPECT_EQ(camera.projectPoint({0.01, 0, 0.002}).status, ProjectStatus::kOutsideDomain);
  EXPECT_TRUE(camera.projectPoint({0.2, 0, 0.04}).ok());
}

}  // namespace
}  // namespace alidade
