// SPDX-License-Identifier: MIT
#include "alidade/camera/batch.h"
#include "alidade/camera/camera_variant.h"

#include <cmath>

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include "alidade/core/random.h"
#include "support/model_fixture.h"

namespace alidade {
namespace {

using Jet = ceres::Jet<double, 9>;
using Matrix23 = Eigen::Matrix<double, 2, 3, Eigen::RowMajor>;
using Matrix39 = Eigen::Matrix<double, 3, 9>;

constexpr double kRounding = 1e-12;     // relative: both sides are the same algebra
constexpr double kRayRounding = 1e-10;  // the ray comes back from its pixel, which moves derivatives a little

SE3 anyPose(Random& random) {
  const auto vector = [&](double size) {
    return Eigen::Vector3d(random.uniform(-size, size), random.uniform(-size, size),
                           random.uniform(-size, size));
  };
  return {SO3::exp(vector(1.5)), vector(2)};
}

// d (T Exp(xi) p) / d (p, xi) at xi = 0, by automatic differentiation.
Matrix39 movedPointJacobian(const SE3& pose, const Eigen::Vector3d& point) {
  Eigen::Matrix<Jet, 3, 1> p;
  Eigen::Matrix<Jet, 6, 1> xi;
  for (int i = 0; i < 3; ++i) p[i] = Jet(point[i], i);
  for (int i = 0; i < 6; ++i) xi[i] = Jet(0.0, 3 + i);
  const Eigen::Matrix<Jet, 3, 1> moved = pose.cast<Jet>() * (BasicSE3<Jet>::exp(xi) * p);
  Matrix39 J;
  for (int i = 0; i < 3; ++i) J.row(i) = moved[i].v.transpose();
  return J;
}

// Calls check(camera, ray) for rays of all models and all their sets of parameters. @returns how often
template <class F>
std::size_t forEachRay(Random& random, const F& check) {
  std::size_t count = 0;
  AllModels::forEach([&]<class M>() {
    for (const auto& params : ModelFixture<M>::paramSets()) {
      const Camera<M> camera(params);
      for (int i = 0; i < 20; ++i) {
        const auto ray = camera.unproject(
            {random.uniform(0, kTestImage.width - 1.0), random.uniform(0, kTestImage.height - 1.0)});
        if (!ray) continue;
        check(camera, *ray);
        ++count;
      }
    }
  });
  return count;
}

TEST(BatchJacobians, ChainPointPoseAndParameters) {
  Random random(3);
  const std::size_t count = forEachRay(random, [&](const auto& camera, const Eigen::Vector3d& ray) {
    constexpr int kParams = std::decay_t<decltype(camera)>::kNumParams;
    const SE3 pose = anyPose(random);
    const Eigen::Vector3d point = pose.inverse() * (random.uniform(0.5, 5) * ray);
    Matrix23 J_px_cam;
    Eigen::Matrix<double, 2, kParams, Eigen::RowMajor> J_px_params;
    if (!camera.project(pose * point, J_px_cam.data(), J_px_params.data()).ok()) return;  // a ray on the rim
    double u = 0;
    double v = 0;
    ProjectStatus status = ProjectStatus::kOutsideDomain;
    Matrix23 by_point;
    Eigen::Matrix<double, 2, 6, Eigen::RowMajor> by_pose;
    Eigen::Matrix<double, 2, kParams, Eigen::RowMajor> by_params;
    projectBatch(AnyCamera(camera), pose, {{&point[0], 1}, {&point[1], 1}, {&point[2], 1}},
                 {{&u, 1}, {&v, 1}, {&status, 1}}, {by_point.data(), by_pose.data(), by_params.data()});
    ASSERT_EQ(status, ProjectStatus::kOk);
    const Eigen::Matrix<double, 2, 9> expected = J_px_cam * movedPointJacobian(pose, point);
    const double size = J_px_cam.norm() * (1 + point.norm());
    EXPECT_LE((by_point - expected.leftCols<3>()).norm(), kRounding * size);
    EXPECT_LE((by_pose - expected.rightCols<6>()).norm(), kRounding * size);
    EXPECT_LE((by_params - J_px_params).norm(), kRounding * (J_px_params.norm() + size));
  });
  EXPECT_GT(count, 500u);
}

TEST(BatchJacobians, OfRaysAreTheInverseOfTheProjectionsOnTheSphere) {
  Random random(4);
  const std::size_t count = forEachRay(random, [&](const auto& camera, const Eigen::Vector3d& ray) {
    Matrix23 J_px_ray;
    const Projection projection = camera.project(ray, J_px_ray.data(), nullptr);
    if (!projection.ok()) return;  // a ray on the rim
    Eigen::Vector3d found;
    ProjectStatus status = ProjectStatus::kOutsideDomain;
    Eigen::Matrix<double, 3, 2, Eigen::RowMajor> J_ray_px;
    unprojectBatch(AnyCamera(camera), {{&projection.pixel[0], 1}, {&projection.pixel[1], 1}},
                   {{&found[0], 1}, {&found[1], 1}, {&found[2], 1}, {&status, 1}}, J_ray_px.data());
    ASSERT_EQ(status, ProjectStatus::kOk);
    const double size = J_px_ray.norm() * J_ray_px.norm();
    EXPECT_LE((J_px_ray * J_ray_px - Eigen::Matrix2d::Identity()).norm(), kRayRounding * size);
    EXPECT_LE((ray.transpose() * J_ray_px).norm(), kRayRounding * J_ray_px.norm());
  });
  EXPECT_GT(count, 500u);
}

}  // namespace
}  // namespace alidade
