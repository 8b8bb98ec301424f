// SPDX-License-Identifier: MIT
// What SO(3) and SE(3) must both do, on the same hard points.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <unsupported/Eigen/MatrixFunctions>

#include "alidade/core/random.h"
#include "alidade/geometry/se3.h"
#include "alidade/geometry/so3.h"
#include "geometry/group_cases.h"
#include "geometry/matrix_near.h"

namespace alidade {
namespace {

// A handful of roundings on translations of a few metres.
constexpr double kGroupTolerance = 1e-13;
// Entries of R^T R after one normalisation: a few roundings of 1, however many products came before.
constexpr double kOrthonormalTolerance = 2e-15;
constexpr int kNumRandomTriples = 2000;

template <class Group>
class GroupAxioms : public testing::Test {
 protected:
  /// A random one of the hard and random points.
  static Group draw(Random& random) {
    static const auto kTangents = allTangents<Group>();
    return Group::exp(kTangents[random.index(kTangents.size())]);
  }
};

using Groups = testing::Types<SO3, SE3>;
TYPED_TEST_SUITE(GroupAxioms, Groups);

testing::AssertionResult isRotation(const SO3& rotation) {
  const Eigen::Matrix3d R = rotation.matrix();
  if (!(std::abs(R.determinant() - 1.0) <= kOrthonormalTolerance)) {
    return testing::AssertionFailure() << "determinant " << R.determinant();
  }
  return isNear(R.transpose() * R, Eigen::Matrix3d::Identity(), kOrthonormalTolerance);
}

/// The Lie algebra element: 3x3, or 4x4 for a twist.
Eigen::Matrix3d algebra(const SO3::Tangent& w) {
  return hat(w);
}
Eigen::Matrix4d algebra(const SE3::Tangent& xi) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Zero();
  m.topLeftCorner<3, 3>() = hat(xi.tail<3>());
  m.topRightCorner<3, 1>() = xi.head<3>();
  return m;
}

TYPED_TEST(GroupAxioms, DefaultIsTheNeutralElement) {
  const TypeParam identity;
  EXPECT_TRUE(isNear(identity.matrix(), TypeParam::exp(TypeParam::Tangent::Zero()).matrix(), 0.0));
  int num_checked = 0;
  for (const auto& tangent : allTangents<TypeParam>()) {
    const TypeParam x = TypeParam::exp(tangent);
    ASSERT_TRUE(isNear((identity * x).matrix(), x.matrix(), kGroupTolerance));
    ASSERT_TRUE(isNear((x * identity).matrix(), x.matrix(), kGroupTolerance));
    ++num_checked;
  }
  EXPECT_EQ(num_checked, kNumAllTangents<TypeParam>);
}

TYPED_TEST(GroupAxioms, InverseUndoes) {
  const TypeParam identity;
  int num_checked = 0;
  for (const auto& tangent : allTangents<TypeParam>()) {
    const TypeParam x = TypeParam::exp(tangent);
    ASSERT_TRUE(isNear((x * x.inverse()).matrix(), identity.matrix(), kGroupTolerance));
    ASSERT_TRUE(isNear((x.inverse() * x).matrix(), identity.matrix(), kGroupTolerance));
    ASSERT_TRUE(isNear(x.inverse().matrix(), x.matrix().inverse(), kGroupTolerance));
    ++num_checked;
  }
  EXPECT_EQ(num_checked, kNumAllTangents<TypeParam>);
}

TYPED_TEST(GroupAxioms, ProductIsAssociativeAndThatOfTheMatrices) {
  Random random(21);
  for (int i = 0; i < kNumRandomTriples; ++i) {
    const TypeParam x = this->draw(random);
    const TypeParam y = this->draw(random);
    const TypeParam z = this->draw(random);
    ASSERT_TRUE(isNear(((x * y) * z).matrix(), (x * (y * z)).matrix(), kGroupTolerance));
    ASSERT_TRUE(isNear((x * y).matrix(), x.matrix() * y.matrix(), kGroupTolerance));
  }
}

TYPED_TEST(GroupAxioms, ActionOnAPointIsThatOfTheProduct) {
  Random random(22);
  for (int i = 0; i < kNumRandomTriples; ++i) {
    const TypeParam x = this->draw(random);
    const TypeParam y = this->draw(random);
    const Eigen::Vector3d p = randomVector(random, -3.0, 3.0);
    ASSERT_TRUE(isNear((x * y) * p, x * (y * p), kGroupTolerance));
  }
}

TYPED_TEST(GroupAxioms, LongProductsStayOnTheGroup) {
  constexpr int kNumFactors = 100000;
  Random random(23);
  TypeParam x;
  for (int i = 0; i < kNumFactors; ++i) {
    x = x * this->draw(random);
    ASSERT_TRUE(isRotation(rotationOf(x))) << "after factor " << i;
  }
}

TYPED_TEST(GroupAxioms, ManySmallStepsAddUp) {
  constexpr int kNumSteps = 100000;
  // Each step rounds the quaternion by 1e-16; at the worst all in one direction.
  constexpr double kSumTolerance = kNumSteps * 2e-16;
  Random random(24);
  const typename TypeParam::Tangent tangent = randomTangent<TypeParam>(random);
  const TypeParam step = TypeParam::exp(tangent / kNumSteps);
  TypeParam x;
  for (int i = 0; i < kNumSteps; ++i) x = x * step;
  EXPECT_TRUE(isNear(x.matrix(), TypeParam::exp(tangent).matrix(), kSumTolerance));
}

TYPED_TEST(GroupAxioms, ExpIsTheMatrixExponential) {
  constexpr double kMatrixExponentialTolerance = 1e-13;  // what Eigen's scaling and squaring keeps
  int num_checked = 0;
  for (const auto& tangent : allTangents<TypeParam>()) {
    const TypeParam x = TypeParam::exp(tangent);
    ASSERT_TRUE(isRotation(rotationOf(x))) << tangent.transpose();
    ASSERT_TRUE(isNear(x.matrix(), algebra(tangent).exp(), kMatrixExponentialTolerance))
        << tangent.transpose();
    ++num_checked;
  }
  EXPECT_EQ(num_checked, kNumAllTangents<TypeParam>);
}

TYPED_TEST(GroupAxioms, ExpUndoesLog) {
  int num_checked = 0;
  for (const auto& tangent : allTangents<TypeParam>()) {
    const TypeParam x = TypeParam::exp(tangent);
    const TypeParam again = TypeParam::exp(x.log());
    ASSERT_TRUE(isNear(again.matrix(), x.matrix(), kGroupTolerance)) << tangent.transpose();
    ++num_checked;
  }
  EXPECT_EQ(num_checked, kNumAllTangents<TypeParam>);
}

TYPED_TEST(GroupAxioms, LogUndoesExp) {
  int num_checked = 0;
  for (const auto& tangent : allTangents<TypeParam>()) {
    const typename TypeParam::Tangent back = TypeParam::exp(tangent).log();
    // Rounding decides which of the two vectors of a half turn comes back.
    const bool is_half_turn = rotationPart(tangent).norm() > kPi - kGroupTolerance;
    if (is_half_turn && rotationPart(back).dot(rotationPart(tangent)) < 0.0) {
      ASSERT_TRUE(isNear(rotationPart(back), -rotationPart(tangent), kGroupTolerance));
      ASSERT_TRUE(isNear(TypeParam::exp(back).matrix(), TypeParam::exp(tangent).matrix(), kGroupTolerance));
    } else {
      ASSERT_TRUE(isNear(back, tangent, kGroupTolerance));
    }
    ++num_checked;
  }
  EXPECT_EQ(num_checked, kNumAllTangents<TypeParam>);
}

TYPED_TEST(GroupAxioms, LogOfAnyProductHasAnAngleUpToPi) {
  Random random(25);
  for (int i = 0; i < kNumRandomTriples; ++i) {
    TypeParam x = this->draw(random);
    x = x * this->draw(random);
    x = x * this->draw(random);
    const typename TypeParam::Tangent tangent = x.log();
    ASSERT_LE(rotationPart(tangent).norm(), kPi + 1e-15);
    ASSERT_TRUE(isNear(TypeParam::exp(tangent).matrix(), x.matrix(), kGroupTolerance));
  }
}

TYPED_TEST(GroupAxioms, LogPassesThroughHalfATurn) {
  // Two rotations about one axis whose angles add up to pi and to a little on either side of it. Beyond pi
  // the rotation vector is the one of the other way round.
  int num_checked = 0;
  for (const Eigen::Vector3d& axis : hardAxes()) {
    for (const double beyond : {-1e-3, -kNearAngle, 0.0, kNearAngle, 1e-3}) {
      typename TypeParam::Tangent first = TypeParam::Tangent::Zero();
      typename TypeParam::Tangent second = TypeParam::Tangent::Zero();
      first.template tail<3>() = 2.0 * axis;
      second.template tail<3>() = (kPi - 2.0 + beyond) * axis;
      const TypeParam x = TypeParam::exp(first) * TypeParam::exp(second);
      const Eigen::Vector3d w = rotationPart(x.log());
      ASSERT_NEAR(w.norm(), kPi - std::abs(beyond), kGroupTolerance);
      if (beyond != 0.0) {
        const Eigen::Vector3d expected = (beyond < 0.0 ? kPi + beyond : beyond - kPi) * axis;
        ASSERT_TRUE(isNear(w, expected, kGroupTolerance)) << axis.transpose() << " by " << beyond;
      }
      ASSERT_TRUE(isNear(TypeParam::exp(x.log()).matrix(), x.matrix(), kGroupTolerance));
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 10 * 5);
}

TYPED_TEST(GroupAxioms, AdjointMovesATangentAcross) {
  Random random(26);
  int num_checked = 0;
  for (const auto& tangent : allTangents<TypeParam>()) {
    const TypeParam x = TypeParam::exp(tangent);
    const typename TypeParam::Tangent d = randomTangent<TypeParam>(random, 1.0);
    const typename TypeParam::Tangent moved = x.adjoint() * d;
    ASSERT_TRUE(isNear((x * TypeParam::exp(d) * x.inverse()).matrix(), TypeParam::exp(moved).matrix(),
                       kGroupTolerance));
    ASSERT_TRUE(isNear(algebra(moved), x.matrix() * algebra(d) * x.matrix().inverse(), kGroupTolerance));
    ++num_checked;
  }
  EXPECT_EQ(num_checked, kNumAllTangents<TypeParam>);
}

}  // namespace
}  // namespace alidade
