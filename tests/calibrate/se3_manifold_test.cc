// SPDX-License-Identifier: MIT
#include "alidade/calibrate/se3_manifold.h"

#include <ceres/manifold_test_utils.h>
#include <gmock/gmock.h>

#include <numbers>

#include "alidade/core/random.h"

namespace alidade {
namespace {

using namespace ceres;  // NOLINT: the macro below names Ceres' matchers without their namespace

SE3 randomPose(Random& random, double angle) {
  Eigen::Vector3d axis(random.normal(), random.normal(), random.normal());
  SE3 pose;
  pose.rotation = SO3::exp(angle * axis.normalized());
  pose.translation = {random.normal(), random.normal(), random.normal()};
  return pose;
}

TEST(SE3Manifold, HoldsCeresInvariants) {
  constexpr double kTolerance = 1e-9;
  const SE3Manifold manifold;
  Random random(1);
  int num_checked = 0;
  for (const double angle : {0.0, 1e-9, 0.3, 1.5, std::numbers::pi - 1e-6}) {
    for (const double step : {0.0, 1e-9, 0.5, 2.0}) {
      const PoseBlock x = toBlock(randomPose(random, angle));
      const PoseBlock y = toBlock(fromBlock(x.data()) * randomPose(random, step));
      Vector x_vector = Eigen::Map<const Eigen::Matrix<double, 7, 1>>(x.data());
      Vector y_vector = Eigen::Map<const Eigen::Matrix<double, 7, 1>>(y.data());
      Vector delta = 0.7 * Eigen::Matrix<double, 6, 1>::Random();
      EXPECT_THAT_MANIFOLD_INVARIANTS_HOLD(manifold, x_vector, delta, y_vector, kTolerance);
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 20);
}

TEST(SE3Manifold, TangentIsTranslationThenRotationInTrueRadians) {
  const SE3Manifold manifold;
  Random random(2);
  const SE3 pose = randomPose(random, 1.0);
  const PoseBlock x = toBlock(pose);
  const std::array<double, 6> delta = {0.1, -0.2, 0.3, 0, 0, 0.4};
  PoseBlock moved{};
  ASSERT_TRUE(manifold.Plus(x.data(), delta.data(), moved.data()));
  const SE3 step = pose.inverse() * fromBlock(moved.data());
  EXPECT_NEAR(step.rotation.log().norm(), 0.4, 1e-12);
  EXPECT_LE((step.log() - Eigen::Map<const SE3::Vec6>(delta.data())).norm(), 1e-12);
}

}  // namespace
}  // namespace alidade
