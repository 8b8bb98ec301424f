// SPDX-License-Identifier: MIT
#include "alidade/camera/any_rig.h"

#include <gmock/gmock.h>

#include <cmath>

#include <Eigen/Geometry>

#include "support/message_of.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::HasSubstr;

MountedCamera mounted(const std::string& name, std::string_view model, const std::vector<double>& params,
                      const SE3& camera_from_rig) {
  return {.name = name,
          .camera = AnyCamera::make(model, params),
          .image_size = {640, 480},
          .camera_from_rig = camera_from_rig};
}

AnyRig twoCameras() {
  const SE3 turned{SO3::exp(Eigen::Vector3d(0.1, -0.7, 0.2)), Eigen::Vector3d(-0.3, 0.02, 0.1)};
  return AnyRig({mounted("left", "radtan", {500, 501, 320, 240, -0.2, 0.05, 1e-3, -1e-3, 0}, {}),
                 mounted("right", "kannala_brandt", {200, 201, 322, 238, 0.01, -0.002, 0, 0}, turned)});
}

TEST(AnyRig, ProjectsPointsOfItsFrameThroughEachCamera) {
  const AnyRig rig = twoCameras();
  const Eigen::Vector3d point(0.2, -0.1, 1.5);
  const std::vector<Projection> projections = rig.project(point);
  ASSERT_EQ(projections.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    const MountedCamera& camera = rig.camera(i);
    ASSERT_TRUE(projections[i].ok());
    EXPECT_EQ(projections[i].pixel, camera.camera.project(camera.camera_from_rig * point).pixel);
    EXPECT_EQ(projections[i].pixel, rig.project(i, point).pixel);
  }
  // Behind the first camera, and beside the second, which sees more than half of all directions.
  const std::vector<Projection> behind = rig.project(Eigen::Vector3d(3, 0, -0.1));
  EXPECT_EQ(behind[0].status, ProjectStatus::kBehind);
  EXPECT_TRUE(behind[1].ok());
}

TEST(AnyRig, FindsTheRaysOfPixelsInItsFrame) {
  const AnyRig rig = twoCameras();
  int num_rays = 0;
  for (std::size_t i = 0; i < 2; ++i) {
    for (const double u : {20.0, 310.5, 600.0}) {
      const Eigen::Vector2d pixel(u, 250);
      const auto ray = rig.unproject(i, pixel);
      ASSERT_TRUE(ray);
      EXPECT_LT((rig.camera(i).camera_from_rig * ray->origin).norm(), 1e-15);
      EXPECT_NEAR(ray->direction.norm(), 1, 1e-15);
      EXPECT_LT((rig.project(i, ray->origin + 2 * ray->direction).pixel - pixel).norm(), 1e-8);
      ++num_rays;
    }
  }
  EXPECT_EQ(num_rays, 6);
  EXPECT_FALSE(rig.unproject(1, Eigen::Vector2d(5000, 5000)));
}

TEST(AnyRig, KnowsItsCamerasByUniqueNames) {
  const AnyRig rig = twoCameras();
  EXPECT_EQ(rig.index("right"), 1u);
  try {
    (void)rig.index("rigt");
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kUsage);
    EXPECT_THAT(error.what(),
                AllOf(HasSubstr("no camera 'rigt'"), HasSubstr("left, right"), HasSubstr("'right'?")));
  }
  EXPECT_THAT(messageOf([] { (void)AnyRig({}); }), HasSubstr("no camera"));
  EXPECT_THAT(messageOf([&] {
                (void)AnyRig({rig.camera(0), rig.camera(0)});
              }),
              HasSubstr("two cameras of the name 'left'"));
}

}  // namespace
}  // namespace alidade
