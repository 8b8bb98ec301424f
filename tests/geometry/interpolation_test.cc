// SPDX-License-Identifier: MIT
#include "alidade/geometry/interpolation.h"

#include <gtest/gtest.h>

#include "alidade/core/random.h"
#include "geometry/group_cases.h"
#include "geometry/matrix_near.h"

namespace alidade {
namespace {

constexpr double kTolerance = 1e-13;              // a handful of roundings on translations of a few metres
constexpr double kMaxRelativeAngle = kPi - 1e-9;  // at pi there are two shortest arcs
constexpr int kNumPairs = 500;

template <class Group>
class Interpolation : public testing::Test {
 protected:
  struct Pair {
    Group a;
    Group b;
  };
  /// Any start, and an end less than half a turn away.
  static Pair draw(Random& random) {
    const Group a = Group::exp(randomTangent<Group>(random));
    return {a, a * Group::exp(randomTangent<Group>(random, kMaxRelativeAngle))};
  }
};

using Groups = testing::Types<SO3, SE3>;
TYPED_TEST_SUITE(Interpolation, Groups);

TYPED_TEST(Interpolation, StartsAndEndsAtTheEnds) {
  Random random(41);
  for (int i = 0; i < kNumPairs; ++i) {
    const auto [a, b] = this->draw(random);
    ASSERT_TRUE(isNear(interpolate(a, b, 0.0).matrix(), a.matrix(), kTolerance));
    ASSERT_TRUE(isNear(interpolate(a, b, 1.0).matrix(), b.matrix(), kTolerance));
    ASSERT_TRUE(isNear(interpolate(a, a, 0.7).matrix(), a.matrix(), kTolerance));
  }
}

TYPED_TEST(Interpolation, IsTheSameFromEitherEnd) {
  Random random(42);
  for (int i = 0; i < kNumPairs; ++i) {
    const auto [a, b] = this->draw(random);
    const double t = random.uniform();
    ASSERT_TRUE(isNear(interpolate(a, b, t).matrix(), interpolate(b, a, 1.0 - t).matrix(), kTolerance));
  }
}

TYPED_TEST(Interpolation, HasConstantSpeed) {
  constexpr double kStep = 0.125;
  Random random(43);
  int num_checked = 0;
  for (int i = 0; i < kNumPairs; ++i) {
    const auto [a, b] = this->draw(random);
    const typename TypeParam::Tangent step = kStep * (a.inverse() * b).log();
    for (double t = 0.0; t < 1.0; t += kStep) {
      const TypeParam here = interpolate(a, b, t);
      const TypeParam there = interpolate(a, b, t + kStep);
      ASSERT_TRUE(isNear((here.inverse() * there).log(), step, kTolerance));
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 8 * kNumPairs);
}

TYPED_TEST(Interpolation, DoesNotDependOnEitherFrame) {
  Random random(44);
  for (int i = 0; i < kNumPairs; ++i) {
    const auto [a, b] = this->draw(random);
    const TypeParam left = TypeParam::exp(randomTangent<TypeParam>(random));
    const TypeParam right = TypeParam::exp(randomTangent<TypeParam>(random));
    const double t = random.uniform();
    ASSERT_TRUE(isNear(interpolate(left * a * right, left * b * right, t).matrix(),
                       (left * interpolate(a, b, t) * right).matrix(), kTolerance));
  }
}

TEST(InterpolateRotation, TakesTheShortWayRound) {
  const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
  // 190 degrees one way is 170 the other, and half of that is 85 backwards.
  const double degree = kPi / 180.0;
  const SO3 middle = interpolate(SO3(), SO3::exp(190.0 * degree * z), 0.5);
  EXPECT_TRUE(isNear(middle.log(), -85.0 * degree * z, kTolerance));
  const SO3 half = interpolate(SO3(), SO3::exp(170.0 * degree * z), 0.5);
  EXPECT_TRUE(isNear(half.log(), 85.0 * degree * z, kTolerance));
}

TEST(InterpolateRotation, HalfATurnIsCrossedOnOneOfTheArcs) {
  const SO3 half_turn = SO3::fromQuaternion(Eigen::Quaterniond(0.0, 0.0, -1.0, 0.0));
  EXPECT_TRUE(
      isNear(interpolate(SO3(), half_turn, 0.5).log(), Eigen::Vector3d(0.0, kPi / 2, 0.0), kTolerance));
  EXPECT_TRUE(isNear(interpolate(SO3(), half_turn, 1.0).matrix(), half_turn.matrix(), kTolerance));
}

TEST(InterpolateMotion, WithoutARotationIsAStraightLine) {
  const SE3 a{SO3::exp(Eigen::Vector3d(0.3, 0.2, 0.1)), Eigen::Vector3d(1.0, 2.0, 3.0)};
  const SE3 b{a.rotation, Eigen::Vector3d(3.0, 2.0, -1.0)};
  EXPECT_TRUE(isNear(interpolate(a, b, 0.25).translation, Eigen::Vector3d(1.5, 2.0, 2.0), kTolerance));
}

}  // namespace
}  // namespace alidade
