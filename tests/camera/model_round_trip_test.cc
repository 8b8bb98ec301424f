// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <limits>
#include <string>

#include "alidade/core/random.h"
#include "support/model_fixture.h"

namespace alidade {
namespace {

constexpr double kRayTolerance = 1e-9;    // rad, the project's promise
constexpr double kPixelTolerance = 1e-7;  // px, for an iterative inverse
constexpr int kNumRays = 100000;          // of each set of parameters; all passes with 1 000 000 too
constexpr int kNumPixels = 50000;
constexpr int kNumRandomSets = 100;
constexpr int kNumRaysOfRandomSet = 1000;

template <class M>
class ModelRoundTrip : public testing::Test {};
TYPED_TEST_SUITE(ModelRoundTrip, AllModelTypes, ModelName);

struct Worst {
  int num_ok = 0;
  double ray_rad = 0;
};

// Half of the rays over all angles, half within the domain up to its very rim: each projects exactly if it is
// in the domain, and comes back.
template <class M>
void checkRays(const Camera<M>& camera, int num_rays, std::uint64_t seed, Worst& worst) {
  Random random(seed);
  const double max_angle = camera.cone().max_angle_rad;
  for (int i = 0; i < num_rays; ++i) {
    const double limit = i % 2 == 0 ? std::numbers::pi : max_angle;
    const double angle = i % 100 == 1 ? max_angle * (1 - 1e-7 * random.uniform()) : limit * random.uniform();
    const Eigen::Vector3d ray = rayAt(angle, random.uniform(0, 2 * std::numbers::pi));
    const Projection projection = camera.project(random.uniform(0.1, 50.0) * ray);
    // The cosine resolves angles only down to a root of rounding where its slope vanishes.
    const double blur = 1e-15 + 1e-15 / std::max(1e-8, std::sin(max_angle));
    if (angle < max_angle - blur) {
      ASSERT_TRUE(projection.ok()) << "angle " << angle << " of " << max_angle;
    }
    if (!projection.ok()) continue;
    ASSERT_LE(angle, max_angle + blur);
    const auto back = camera.unproject(projection.pixel);
    ASSERT_TRUE(back) << "angle " << angle << " of " << max_angle;
    ASSERT_NEAR(back->norm(), 1.0, 1e-14);
    const double error = angleBetween(*back, ray);
    ASSERT_LE(error, kRayTolerance) << "angle " << angle << " of " << max_angle;
    worst.ray_rad = std::max(worst.ray_rad, error);
    ++worst.num_ok;
  }
}

// Pixels of the image and as much again on each side: each has no ray, or one that projects to it.
template <class M>
int checkPixels(const Camera<M>& camera, int num_pixels, std::uint64_t seed, double& worst) {
  Random random(seed);
  int num_ok = 0;
  for (int i = 0; i < num_pixels; ++i) {
    const Eigen::Vector2d pixel(random.uniform(-1.0, 2.0) * kTestImage.width,
                                random.uniform(-1.0, 2.0) * kTestImage.height);
    const auto ray = camera.unproject(pixel);
    if (!ray) continue;
    const Projection back = camera.project(*ray);
    EXPECT_TRUE(back.ok()) << pixel.transpose();
    const double error = (back.pixel - pixel).norm();
    EXPECT_LE(error, kPixelTolerance) << pixel.transpose();
    worst = std::max(worst, error);
    ++num_ok;
  }
  return num_ok;
}

TYPED_TEST(ModelRoundTrip, EveryRayThatProjectsComesBack) {
  using M = TypeParam;
  Worst all;
  int set = 0;
  for (const auto& params : ModelFixture<M>::paramSets()) {
    SCOPED_TRACE("set " + std::to_string(set++));
    Worst worst;
    checkRays(Camera<M>(params), kNumRays, 1, worst);
    EXPECT_GE(worst.num_ok, kNumRays / 2 - kNumRays / 100);
    all.ray_rad = std::max(all.ray_rad, worst.ray_rad);
    if (testing::Test::HasFatalFailure()) return;
  }
  std::printf("%-14s worst ray error %.1e rad\n", std::string(M::kId).c_str(), all.ray_rad);
}

TYPED_TEST(ModelRoundTrip, EveryPixelWithARayComesBack) {
  using M = TypeParam;
  double worst = 0;
  int set = 0;
  for (const auto& params : ModelFixture<M>::paramSets()) {
    SCOPED_TRACE("set " + std::to_string(set++));
    EXPECT_GE(checkPixels(Camera<M>(params), kNumPixels, 2, worst), kNumPixels / 40);
  }
  std::printf("%-14s worst pixel error %.1e px\n", std::string(M::kId).c_str(), worst);
}

// Lenses that nobody would build, and whatever folds and poles they have.
TYPED_TEST(ModelRoundTrip, HoldsForRandomParameters) {
  using M = TypeParam;
  Random random(5);
  Worst worst;
  double worst_px = 0;
  int num_limited = 0;
  for (int i = 0; i < kNumRandomSets; ++i) {
    const auto params = ModelFixture<M>::randomParams(random);
    std::string text;
    for (const double value : params) text += " " + std::to_string(value);
    SCOPED_TRACE("set" + text);
    const Camera<M> camera(params);
    num_limited += camera.cone().is_limited_by_fold ? 1 : 0;
    checkRays(camera, kNumRaysOfRandomSet, streamSeed(6, static_cast<std::uint64_t>(i)), worst);
    checkPixels(camera, kNumRaysOfRandomSet, streamSeed(7, static_cast<std::uint64_t>(i)), worst_px);
    if (testing::Test::HasFailure()) return;
  }
  std::printf("%-14s %d of %d random sets end at a fold or pole; worst %.1e rad, %.1e px\n",
              std::string(M::kId).c_str(), num_limited, kNumRandomSets, worst.ray_rad, worst_px);
  EXPECT_GE(worst.num_ok, kNumRandomSets * (kNumRaysOfRandomSet / 2 - kNumRaysOfRandomSet / 50));
}

// Pixels on both sides of the image of the domain's rim, down to rounding.
TYPED_TEST(ModelRoundTrip, HoldsOnTheVeryRim) {
  using M = TypeParam;
  for (const auto& params : ModelFixture<M>::paramSets()) {
    const Camera<M> camera(params);
    int num_checked = 0;
    for (int k = 0; k < 100; ++k) {
      const Eigen::Vector3d ray = rayAt(camera.cone().max_angle_rad * (1 - 1e-12), 0.0628 * k);
      const Projection projection = camera.project(ray);
      if (!projection.ok()) continue;
      const Eigen::Vector2d middle(params[2], params[3]);
      const Eigen::Vector2d out = (projection.pixel - middle).normalized();
      const double size = 1 + (projection.pixel - middle).norm();
      for (const double step : {-1e-6, -1e-9, -1e-12, -1e-15, 0.0, 1e-15, 1e-12, 1e-9, 1e-6}) {
        const Eigen::Vector2d pixel = projection.pixel + step * size * out;
        const auto back = camera.unproject(pixel);
        if (!back) continue;
        const Projection again = camera.project(*back);
        ASSERT_TRUE(again.ok());
        // Towards a pole a pixel's distance from the middle grows with the square of itself.
        ASSERT_LE((again.pixel - pixel).norm(), kPixelTolerance + 1e-15 * size * size);
        ++num_checked;
      }
    }
    EXPECT_GE(num_checked, 300);
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
          Eigen::Vector3d(kInf, 0, 1), Eigen::Vector3d(0, 0, kInf), Eigen::Vector3d(0, 0, -kInf),
          Eigen::Vector3d(1e200, 0, 1e200), Eigen::Vector3d(1e-200, 0, 1e-200), Eigen::Vector3d(0, 0, -1)}) {
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
