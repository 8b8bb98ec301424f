// SPDX-License-Identifier: MIT
#include "alidade/geometry/rotation_conversions.h"

#include <gtest/gtest.h>

#include "alidade/core/random.h"

namespace alidade {
namespace {

Eigen::Vector3d randomVector(Random& random) {
  return {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
}

TEST(BestRotation, IsThatWhichTurnedTheVectors) {
  Random random(1);
  int num_checked = 0;
  for (int i = 0; i < 100; ++i, ++num_checked) {
    const SO3 truth = SO3::exp(3 * randomVector(random));
    Eigen::Matrix3d correlation = Eigen::Matrix3d::Zero();
    for (int k = 0; k < 5; ++k) {
      const Eigen::Vector3d a = randomVector(random);
      correlation += random.uniform(0.1, 2) * (truth * a) * a.transpose();
    }
    EXPECT_LT((bestRotation(correlation).inverse() * truth).log().norm(), 1e-12);
  }
  EXPECT_EQ(num_checked, 100);
}

// Vectors of one plane could as well be mirrored at it.
TEST(BestRotation, IsNoReflection) {
  Random random(2);
  for (int i = 0; i < 20; ++i) {
    const SO3 truth = SO3::exp(3 * randomVector(random));
    Eigen::Matrix3d correlation = Eigen::Matrix3d::Zero();
    for (int k = 0; k < 4; ++k) {
      Eigen::Vector3d a = randomVector(random);
      a.z() = 0;
      correlation += (truth * a) * a.transpose();
    }
    EXPECT_LT((bestRotation(correlation).inverse() * truth).log().norm(), 1e-12) << i;
  }
}

}  // namespace
}  // namespace alidade
