// SPDX-License-Identifier: MIT
#include "alidade/footage/geometry/essential.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "footage/points_scene.h"

namespace alidade {
namespace {

using testing::randomDirection;

TEST(Essential, TrueMotionIsAmongTheSolutions) {
  Random random(3);
  int num_found = 0;
  constexpr int kCases = 300;
  for (int i = 0; i < kCases; ++i) {
    const SE3 b_from_a{SO3::exp(random.uniform(0, 1.5) * randomDirection(random)), randomDirection(random)};
    std::array<RayPair, 5> pairs;
    for (RayPair& pair : pairs) {
      const Eigen::Vector3d p = random.uniform(1, 8) * randomDirection(random);  // all around, also behind
      pair = {p.normalized(), (b_from_a * p).normalized()};
    }
    const Eigen::Matrix3d truth = essentialMatrix(b_from_a);
    double nearest = 1;
    for (const Eigen::Matrix3d& E : essentialMatrices(pairs)) {
      for (const RayPair& pair : pairs) EXPECT_NEAR(pair.b.dot(E * pair.a), 0, 1e-9);
      nearest = std::min({nearest, (E - truth).norm(), (E + truth).norm()});
    }
    num_found += nearest < 1e-5 ? 1 : 0;
  }
  EXPECT_GE(num_found, kCases - 3);  // rounding: some samples are all but degenerate
}

TEST(Essential, OneOfTheFourMotionsIsTheTrueOne) {
  Random random(4);
  constexpr int kCases = 50;
  int num_exact = 0;
  for (int i = 0; i < kCases; ++i) {
    const SE3 b_from_a{SO3::exp(random.uniform(0, 3) * randomDirection(random)), randomDirection(random)};
    const auto motions = motionsOf(essentialMatrix(b_from_a));
    const Eigen::Vector3d p = 4 * randomDirection(random);
    const RayPair pair{p.normalized(), (b_from_a * p).normalized()};
    int num_positive = 0;
    for (const SE3& motion : motions) {
      num_positive += (depthsOf(pair, motion) > 0).all() ? 1 : 0;
      if ((motion.rotation.matrix() - b_from_a.rotation.matrix()).norm() < 1e-9 &&
          (motion.translation - b_from_a.translation).norm() < 1e-9)
        num_exact += 1;
    }
    EXPECT_EQ(num_positive, 1);
  }
  EXPECT_EQ(num_exact, kCases);
}

TEST(Essential, DepthsAreThoseOfThePoint) {
  const SE3 b_from_a{SO3::exp(Eigen::Vector3d(0.1, -0.2, 0.05)), Eigen::Vector3d(0.3, 0.1, -0.2)};
  const Eigen::Vector3d p(0.4, -0.3, 2.5);
  const Eigen::Array2d depths = depthsOf({p.normalized(), (b_from_a * p).normalized()}, b_from_a);
  EXPECT_NEAR(depths[0], p.norm(), 1e-12);
  EXPECT_NEAR(depths[1], (b_from_a * p).norm(), 1e-12);
}

}  // namespace
}  // namespace alidade
