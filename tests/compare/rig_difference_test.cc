// SPDX-License-Identifier: MIT
#include "alidade/compare/rig_difference.h"

#include <gtest/gtest.h>

#include "support/image_sizes.h"

namespace alidade {
namespace {

constexpr double kFocal = 500;

AnyCamera pinhole(double cx = 319.5) {
  return AnyCamera::make("pinhole", std::vector<double>{kFocal, kFocal, cx, 239.5});
}

// Three cameras side by side, 0.1 m apart; the last looks at a right angle to the others.
std::vector<RigCameraRecord> rigOf(const AnyCamera& camera, const SE3& rig_from_other = {}) {
  std::vector<RigCameraRecord> rig;
  for (int i = 0; i < 3; ++i) {
    const SO3 rotation = SO3::exp({0, i == 2 ? 1.5 : 0, 0});
    const SE3 pose{rotation, rotation * Eigen::Vector3d(-0.1 * i, 0, 0)};
    rig.push_back(
        {.camera = {.camera = camera, .image_size = kVga}, .camera_from_rig = pose * rig_from_other});
  }
  return rig;
}

TEST(RigDifference, IgnoresTheFrameOfTheRig) {
  const AnyCamera camera = pinhole();
  const auto a = rigOf(camera);
  const auto b = rigOf(camera, SE3{SO3::exp({0.3, -2, 1}), {5, 6, 7}});
  const RigDifference found = rigDifference(a, b, usualDistance(a));
  EXPECT_NEAR(found.distance_m, 2.0, 1e-12);
  ASSERT_EQ(found.transfers.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_LT(found.places[i].distance_m, 1e-12);
    EXPECT_LT(found.places[i].angle_rad, 1e-12);
  }
  ASSERT_TRUE(found.transfers[0] && found.transfers[1]);
  EXPECT_LT(found.transfers[1]->max_px, 1e-9);
  EXPECT_GT(found.transfers[1]->num_compared, 1000);
  EXPECT_FALSE(found.transfers[2]);  // it sees nothing of the others
}

// A camera that is moved along x by d moves points at distance z by f d / z.
TEST(RigDifference, IsThatOfThePose) {
  const AnyCamera camera = pinhole();
  const auto a = rigOf(camera);
  auto b = a;
  b[1].camera_from_rig.translation.x() -= 0.002;
  const RigDifference found = rigDifference(a, b, 4);
  EXPECT_EQ(found.places[0].distance_m, 0);
  EXPECT_NEAR(found.places[1].distance_m, 0.002, 1e-12);
  EXPECT_EQ(found.places[1].angle_rad, 0);
  // The points lie on a sphere: those at the image's corner are nearer to the plane of the camera.
  const double farthest = 4 / std::sqrt(1 + (319.5 * 319.5 + 239.5 * 239.5) / (kFocal * kFocal));
  for (std::size_t to = 0; to < 2; ++to) {
    ASSERT_TRUE(found.transfers[to]);
    EXPECT_EQ(found.transfers[to]->from, 1 - to);
    EXPECT_GT(found.transfers[to]->rms_px, kFocal * 0.002 / 4);
    EXPECT_LT(found.transfers[to]->max_px, kFocal * 0.002 / farthest);
    EXPECT_LE(found.transfers[to]->p95_px, found.transfers[to]->max_px);
  }
}

// A shifted principal point counts as what it does to other cameras' pixels.
TEST(RigDifference, IncludesThatOfTheLenses) {
  const AnyCamera camera = pinhole();
  const AnyCamera shifted = pinhole(321.5);
  const auto a = rigOf(camera);
  auto b = a;
  b[1].camera.camera = shifted;
  const RigDifference found = rigDifference(a, b, 100);
  EXPECT_NEAR(found.transfers[1]->p95_px, 2, 1e-6);
  EXPECT_EQ(found.places[1].angle_rad, 0);
}

TEST(RigDifference, UsesAMetreWhereAllCamerasAreAtOnePlace) {
  const AnyCamera camera = pinhole();
  const std::vector<RigCameraRecord> rig(2, {.camera = {.camera = camera, .image_size = kVga}});
  EXPECT_EQ(usualDistance(rig), 1);
}

}  // namespace
}  // namespace alidade
