// SPDX-License-Identifier: MIT
#include "alidade/geometry/se3.h"

#include <gtest/gtest.h>

#include "geometry/group_cases.h"
#include "geometry/matrix_near.h"

namespace alidade {
namespace {

constexpr double kTolerance = 1e-14;  // a few roundings of numbers up to 10

TEST(Se3, RotatesThenTranslates) {
  // Frame b sits at (1, 2, 3) of frame a, turned a quarter about z.
  const SE3 a_from_b{SO3::exp(Eigen::Vector3d(0.0, 0.0, kPi / 2)), Eigen::Vector3d(1.0, 2.0, 3.0)};
  EXPECT_TRUE(isNear(a_from_b * Eigen::Vector3d(5.0, 0.0, 0.0), Eigen::Vector3d(1.0, 7.0, 3.0), kTolerance));
  EXPECT_TRUE(
      isNear(a_from_b.inverse() * Eigen::Vector3d(1.0, 2.0, 3.0), Eigen::Vector3d::Zero(), kTolerance));
}

TEST(Se3, MatrixActsOnHomogeneousPoints) {
  const SE3 a_from_b{SO3::exp(Eigen::Vector3d(0.4, -0.5, 0.6)), Eigen::Vector3d(1.0, 2.0, 3.0)};
  const Eigen::Vector3d p(0.7, -0.8, 0.9);
  EXPECT_TRUE(isNear(a_from_b.matrix() * p.homogeneous(), (a_from_b * p).homogeneous(), kTolerance));
}

TEST(Se3Exp, TangentIsTranslationThenRotation) {
  SE3::Tangent xi;
  xi << 1.0, 2.0, 3.0, 0.0, 0.0, 0.0;
  EXPECT_TRUE(isNear(SE3::exp(xi).translation, Eigen::Vector3d(1.0, 2.0, 3.0), 0.0));
  EXPECT_TRUE(isNear(SE3::exp(xi).rotation.matrix(), Eigen::Matrix3d::Identity(), 0.0));
}

TEST(Se3Exp, IsAScrewMotion) {
  // A quarter turn about z while moving along x draws a quarter circle of length 1, so of radius 2 / pi.
  SE3::Tangent xi;
  xi << 1.0, 0.0, 0.5, 0.0, 0.0, kPi / 2;
  const SE3 x = SE3::exp(xi);
  EXPECT_TRUE(isNear(x.translation, Eigen::Vector3d(2.0 / kPi, 2.0 / kPi, 0.5), kTolerance));
  EXPECT_TRUE(isNear(x.rotation * Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), kTolerance));
}

TEST(Se3Adjoint, HasTheBlocksOfItsOrder) {
  const SE3 x{SO3::exp(Eigen::Vector3d(0.4, -0.5, 0.6)), Eigen::Vector3d(1.0, 2.0, 3.0)};
  const Eigen::Matrix3d R = x.rotation.matrix();
  SE3::Mat6 expected;
  expected << R, hat(x.translation) * R, Eigen::Matrix3d::Zero(), R;
  EXPECT_TRUE(isNear(x.adjoint(), expected, 0.0));
}

}  // namespace
}  // namespace alidade
