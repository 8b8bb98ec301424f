// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <ceres/jet.h>

#include <algorithm>
#include <cstdio>
#include <vector>

#include "support/model_fixture.h"
#include "support/project_formula.h"

namespace alidade {
namespace {

// Analytic and automatic derivatives differ by rounding alone; a dropped term of the distortion shows far
// above.
constexpr double kJacobianTolerance = 1e-9;

template <class M>
class ModelJacobians : public testing::Test {};
TYPED_TEST_SUITE(ModelJacobians, AllModelTypes, ModelName);

// Angles from the axis to the rim of the domain: the axis itself, both sides of where the series of the arc
// tangent starts (0.001), and both sides of 90 degrees. Those that the domain lacks are taken at its rim.
std::vector<double> angles(double max_angle) {
  const double rim = max_angle * (1 - 1e-9);
  std::vector<double> all = {0.0, 1e-12, 1e-8, 1e-6, 1e-4, 1e-3 * (1 - 1e-6), 1e-3 * (1 + 1e-6), 2e-3};
  constexpr double kRight = std::numbers::pi / 2;
  for (const double off : {-1e-3, -1e-9, 0.0, 1e-9, 1e-3}) all.push_back(std::min(rim, kRight + off));
  for (int i = 1; i <= 20; ++i) all.push_back(rim * i / 20.0);
  return all;
}
constexpr int kNumAngles = 33;

TYPED_TEST(ModelJacobians, AgreeWithAutomaticDifferentiation) {
  using M = TypeParam;
  constexpr int kN = kNumParams<M>;
  using Jet = ceres::Jet<double, 3 + kN>;
  int num_checked = 0;
  double worst = 0;
  const auto sets = ModelFixture<M>::paramSets();
  for (const auto& params : sets) {
    const Camera<M> camera(params);
    for (const double angle : angles(camera.cone().max_angle_rad)) {
      for (int k = 0; k < 12; ++k) {
        for (const double distance : {0.02, 1.0, 300.0}) {
          const Eigen::Vector3d p = distance * rayAt(angle, 0.1 + k * std::numbers::pi / 6);
          double J_px_cam[6];
          double J_px_params[2 * kN];
          const Projection projection = camera.project(p, J_px_cam, J_px_params);
          ASSERT_TRUE(projection.ok()) << "angle " << angle;

          Jet jet_params[kN];
          Jet jet_point[3];
          Jet jet_px[2];
          for (int i = 0; i < 3; ++i) jet_point[i] = Jet(p[i], i);
          for (int i = 0; i < kN; ++i) jet_params[i] = Jet(params[static_cast<std::size_t>(i)], 3 + i);
          ASSERT_TRUE(projectFormula<M>(jet_params, jet_point, jet_px));
          // Near a fold that is the end of a stated inverse, where the slope is infinite, the last digit of
          // the angle changes it by a share of twice the distance from there; zeros among large entries are
          // differences of these.
          const double from_fold = camera.cone().max_angle_rad + M::kEndMargin - angle;
          const double near_fold = camera.cone().is_limited_by_fold ? 4 / from_fold : 0;
          const double share = kIsStatedInverse<M> ? 1e-15 * (1 + near_fold) : 0;
          const double rounding = share * Eigen::Map<Eigen::Vector<double, 6>>(J_px_cam).norm();
          for (int r = 0; r < 2; ++r) {
            EXPECT_NEAR(projection.pixel[r], jet_px[r].a, kJacobianTolerance * (1 + std::abs(jet_px[r].a)));
            for (int i = 0; i < 3; ++i) {
              worst = std::max(
                  worst, std::abs(J_px_cam[3 * r + i] - jet_px[r].v[i]) / (1 + std::abs(jet_px[r].v[i])));
              ASSERT_NEAR(J_px_cam[3 * r + i], jet_px[r].v[i],
                          kJacobianTolerance * (1 + std::abs(jet_px[r].v[i])) + rounding)
                  << "point coordinate " << i << " at angle " << angle;
            }
            for (int i = 0; i < kN; ++i) {
              const double expected = jet_px[r].v[3 + i];
              worst =
                  std::max(worst, std::abs(J_px_params[kN * r + i] - expected) / (1 + std::abs(expected)));
              ASSERT_NEAR(J_px_params[kN * r + i], expected,
                          kJacobianTolerance * (1 + std::abs(expected)) + share * std::abs(expected))
                  << kParamNames<M>[static_cast<std::size_t>(i)] << " at angle " << angle;
            }
          }
          ++num_checked;
        }
      }
    }
  }
  std::printf("%-14s %d points, worst Jacobian entry %.1e\n", std::string(M::kId).c_str(), num_checked,
              worst);
  EXPECT_EQ(num_checked, static_cast<int>(sets.size()) * kNumAngles * 12 * 3);
}

// A central projection does not change along a ray, so the Jacobian maps the ray to nothing.
TYPED_TEST(ModelJacobians, VanishAlongTheRay) {
  using M = TypeParam;
  int num_checked = 0;
  for (const auto& params : ModelFixture<M>::paramSets()) {
    const Camera<M> camera(params);
    for (const double angle : angles(camera.cone().max_angle_rad)) {
      const Eigen::Vector3d ray = rayAt(angle, 1.0);
      Eigen::Matrix<double, 2, 3, Eigen::RowMajor> J_px_cam;
      ASSERT_TRUE(camera.project(ray, J_px_cam.data(), nullptr).ok());
      EXPECT_LE((J_px_cam * ray).norm(), 1e-12 * J_px_cam.norm());
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, static_cast<int>(ModelFixture<M>::paramSets().size()) * kNumAngles);
}

TYPED_TEST(ModelJacobians, AreOptional) {
  using M = TypeParam;
  const Camera<M> camera(ModelFixture<M>::paramSets().front());
  const Eigen::Vector3d p(0.1, -0.2, 1.5);
  double J_px_cam[6];
  double J_px_params[2 * kNumParams<M>];
  const Eigen::Vector2d expected = camera.project(p).pixel;
  EXPECT_EQ(camera.project(p, J_px_cam, nullptr).pixel, expected);
  EXPECT_EQ(camera.project(p, nullptr, J_px_params).pixel, expected);
  EXPECT_EQ(camera.project(p, J_px_cam, J_px_params).pixel, expected);
}

}  // namespace
}  // namespace alidade
