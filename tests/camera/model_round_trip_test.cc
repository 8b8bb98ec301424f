// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <limits>

#include "alidade/core/random.h"
#include "support/model_fixture.h"

namespace alidade {
namespace {

constexpr double kRayTolerance = 1e-9;    // rad, the project's promise
constexpr double kPixelTolerance = 1e-7;  // px, for an iterative inverse
constexpr int kNumRays = 200000;
constexpr int kNumPixels = 50000;

template <class M>
class ModelRoundTrip : public testing::Test {};
TYPED_TEST_SUITE(ModelRoundTrip, AllModelTypes, ModelName);

TYPED_TEST(ModelRoundTrip, EveryRayThatProjectsComesBack) {
  using M = TypeParam;
  for (const auto& params : ModelFixture<M>::paramSets()) {
    const Camera<M> camera(params);
    Random random(1);
    int num_ok = 0;
    double worst = 0;
    for (int i = 0; i < kNumRays; ++i) {
      // Half of the rays over the whole sphere, half within the domain up to its very rim.
      const double limit = i % 2 == 0 ? std::numbers::pi : camera.cone().max_angle_rad;
      const Eigen::Vector3d ray = rayAt(limit * random.uniform(), random.uniform(0, 2 * std::numbers::pi));
      const Projection projection = camera.project(random.uniform(0.1, 50.0) * ray);
      const bool is_in_domain = std::acos(ray.z()) < camera.cone().max_angle_rad - 1e-9;
      if (is_in_domain) {
        ASSERT_TRUE(projection.ok());
      }
      if (!projection.ok()) continue;
      ASSERT_LE(std::acos(std::min(1.0, ray.z())), camera.cone().max_angle_rad + 1e-7);
      const auto back = camera.unproject(projection.pixel);
      ASSERT_TRUE(back) << "angle " << std::acos(ray.z()) << " of " << camera.cone().max_angle_rad;
      EXPECT_NEAR(back->norm(), 1.0, 1e-14);
      worst = std::max(worst, angleBetween(*back, ray));
      ++num_ok;
    }
    EXPECT_GE(num_ok, kNumRays / 2);
    EXPECT_LE(worst, kRayTolerance);
  }
}

TYPED_TEST(ModelRoundTrip, EveryPixelWithARayComesBack) {
  using M = TypeParam;
  for (const auto& params : ModelFixture<M>::paramSets()) {
    const Camera<M> camera(params);
    Random random(2);
    int num_ok = 0;
    for (int i = 0; i < kNumPixels; ++i) {
      // The image and as much again on each side.
      const Eigen::Vector2d pixel(random.uniform(-1.0, 2.0) * kTestImage.width,
                                  random.uniform(-1.0, 2.0) * kTestImage.height);
      const auto ray = camera.unproject(pixel);
      if (!ray) continue;
      const Projection back = camera.project(*ray);
      ASSERT_TRUE(back.ok()) << pixel.transpose();
      ASSERT_LE((back.pixel - pixel).norm(), kPixelTolerance) << pixel.transpose();
      ++num_ok;
    }
    EXPECT_GE(num_ok, kNumPixels / 20);
  }
}

TYPED_TEST(ModelRoundTrip, NeverGivesAPixelOutsideTheDomain) {
  using M = TypeParam;
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInf = std::numeric_limits<double>::infinity();
  for (const auto& params : ModelFixture<M>::paramSets()) {
    const Camera<M> camera(params);
    for (const Eigen::Vector3d& p :
         {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(kNan, 0, 1), Eigen::Vector3d(0, 0, kNan),
          Eigen::Vector3d(kInf, 0, 1), Eigen::Vector3d(0, 0, kInf), Eigen::Vector3d(0, 0, -kInf)}) {
      const Projection projection = camera.project(p);
      EXPECT_FALSE(projection.ok()) << p.transpose();
      EXPECT_TRUE(std::isnan(projection.pixel.x()) && std::isnan(projection.pixel.y()));
    }
    for (const Eigen::Vector2d& px :
         {Eigen::Vector2d(kNan, 0), Eigen::Vector2d(0, kInf), Eigen::Vector2d(-kInf, kNan)}) {
      EXPECT_FALSE(camera.unproject(px)) << px.transpose();
    }
    if (M::kMaxAngle > std::numbers::pi / 2) continue;
    EXPECT_EQ(camera.project({0.1, 0.2, -1}).status, ProjectStatus::kBehind);
    EXPECT_EQ(camera.project({0.1, 0.2, 0}).status, ProjectStatus::kBehind);
  }
}

}  // namespace
}  // namespace alidade
