// SPDX-License-Identifier: MIT
#include "alidade/camera/point_jacobian.h"

#include <cmath>
#include <vector>

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include "alidade/core/random.h"
#include "support/model_fixture.h"

namespace alidade {
namespace {

using Jet = ceres::Jet<double, 9>;
using Matrix23 = Eigen::Matrix<double, 2, 3, Eigen::RowMajor>;
using Matrix39 = Eigen::Matrix<double, 3, 9>;

constexpr double kRounding = 1e-12;  // relative: both sides are the same algebra

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
  forEachModel(AllModels{}, [&](auto tag) {
    using M = typename decltype(tag)::Model;
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

TEST(PixelJacobian, ChainsPointPoseAndParameters) {
  Random random(3);
  const std::size_t count = forEachRay(random, [&](const auto& camera, const Eigen::Vector3d& ray) {
    constexpr int kParams = std::decay_t<decltype(camera)>::kNumParams;
    const SE3 pose = anyPose(random);
    const Eigen::Vector3d point = pose.inverse() * (random.uniform(0.5, 5) * ray);
    Matrix23 J_px_cam;
    Eigen::Matrix<double, 2, kParams, Eigen::RowMajor> J_px_params;
    if (!camera.project(pose * point, J_px_cam.data(), J_px_params.data()).ok()) return;  // a ray on the rim
    const AnyCamera any(camera);
    std::vector<double> values(2 * numPixelInputs(any));
    ASSERT_TRUE(pixelJacobian(any, pose, point, values));
    const Eigen::Map<const Eigen::Matrix<double, 2, 9 + kParams, Eigen::RowMajor>> found(values.data());
    const Eigen::Matrix<double, 2, 9> expected = J_px_cam * movedPointJacobian(pose, point);
    const double size = J_px_cam.norm() * (1 + point.norm());
    EXPECT_LE((found.template leftCols<9>() - expected).norm(), kRounding * size);
    EXPECT_EQ(found.template rightCols<kParams>(), J_px_params);
  });
  EXPECT_GT(count, 500u);
}

TEST(PixelJacobian, IsNotANumberWithoutAPixel) {
  const AnyCamera camera = AnyCamera::make("pinhole", std::vector<double>{500, 500, 320, 240});
  std::vector<double> values(2 * numPixelInputs(camera), 1.0);
  EXPECT_FALSE(pixelJacobian(camera, SE3(), {0, 0, -1}, values));
  EXPECT_EQ(values.size(), 26u);
  for (const double value : values) EXPECT_TRUE(std::isnan(value));
}

TEST(RayJacobian, IsTheInverseOfTheProjectionsOnTheSphere) {
  Random random(4);
  const std::size_t count = forEachRay(random, [&](const auto& camera, const Eigen::Vector3d& ray) {
    const auto J_ray_px = rayJacobian(AnyCamera(camera), ray);
    Matrix23 J_px_ray;
    if (!camera.project(ray, J_px_ray.data(), nullptr).ok()) {
      EXPECT_FALSE(J_ray_px);
      return;
    }
    ASSERT_TRUE(J_ray_px);
    const double size = J_px_ray.norm() * J_ray_px->norm();
    EXPECT_LE((J_px_ray * *J_ray_px - Eigen::Matrix2d::Identity()).norm(), kRounding * size);
    EXPECT_LE((ray.transpose() * *J_ray_px).norm(), kRounding * J_ray_px->norm());
  });
  EXPECT_GT(count, 500u);
}

TEST(RayJacobian, IsNothingWithoutAPixel) {
  const AnyCamera camera = AnyCamera::make("pinhole", std::vector<double>{500, 500, 320, 240});
  EXPECT_FALSE(rayJacobian(camera, {0, 0, -1}));
}

}  // namespace
}  // namespace alidade
