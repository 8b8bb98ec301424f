// SPDX-License-Identifier: MIT
// The Jacobians of SO(3) and SE(3) against automatic differentiation of what they are the derivatives of.
#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <utility>
#include <vector>

#include "alidade/core/random.h"
#include "alidade/geometry/se3.h"
#include "alidade/geometry/so3.h"
#include "geometry/group_cases.h"
#include "geometry/matrix_near.h"

namespace alidade {
namespace {

constexpr double kJetTolerance = 1e-9;  // relative to 1 + |J|; the house's bound for a Jet comparison
constexpr double kInverseTolerance =
    1e-12;  // a 6x6 product with entries up to |translation| / distance to 2 pi
constexpr double kSwitchTolerance = 1e-15;  // one rounding of an entry near 1 and the step between the points

constexpr int kNumBeyondPi = 100;

template <class Group>
using JetOf = ceres::Jet<double, Group::kDim>;
/// The group, its tangents and points over automatic derivatives by one tangent.
template <class Group>
using JetGroupOf = decltype(std::declval<Group>().template cast<JetOf<Group>>());
template <class Group>
using JacobianOf = Eigen::Matrix<double, Group::kDim, Group::kDim>;

/// A perturbation of zero, with its derivatives.
template <class Group>
typename JetGroupOf<Group>::Tangent perturbation() {
  typename JetGroupOf<Group>::Tangent d;
  for (int i = 0; i < Group::kDim; ++i) d[i] = JetOf<Group>(0.0, i);
  return d;
}

template <int Rows, int N>
Eigen::Matrix<double, Rows, N> derivative(const Eigen::Matrix<ceres::Jet<double, N>, Rows, 1>& value) {
  Eigen::Matrix<double, Rows, N> J;
  for (int i = 0; i < Rows; ++i) J.row(i) = value[i].v.transpose();
  return J;
}

template <int N>
testing::AssertionResult agrees(const Eigen::Matrix<double, N, N>& analytic,
                                const Eigen::Matrix<ceres::Jet<double, N>, N, 1>& value) {
  const Eigen::Matrix<double, N, N> automatic = derivative(value);
  return isNear(analytic, automatic, kJetTolerance * (1.0 + automatic.cwiseAbs().maxCoeff()));
}

/// As allTangents(), and rotations beyond pi, where exp() and its Jacobian still are what they are.
template <class Group>
std::vector<typename Group::Tangent> tangentsBeyondPi() {
  auto tangents = allTangents<Group>();
  Random random(31);
  for (int i = 0; i < kNumBeyondPi; ++i) {
    typename Group::Tangent tangent = randomTangent<Group>(random);
    tangent.template tail<3>() += kPi * rotationPart(tangent).normalized() * (i % 2 == 0 ? 0.9 : 0.5);
    tangents.push_back(tangent);
  }
  return tangents;
}

template <class Group>
class GroupJacobians : public testing::Test {};

using Groups = testing::Types<SO3, SE3>;
TYPED_TEST_SUITE(GroupJacobians, Groups);

TYPED_TEST(GroupJacobians, LeftAndRightAreThoseOfExp) {
  using JetGroup = JetGroupOf<TypeParam>;
  using Jet = JetOf<TypeParam>;
  int num_checked = 0;
  for (const auto& tangent : tangentsBeyondPi<TypeParam>()) {
    const JetGroup moved = JetGroup::exp(tangent.template cast<Jet>() + perturbation<TypeParam>());
    const JetGroup back = TypeParam::exp(tangent).inverse().template cast<Jet>();
    ASSERT_TRUE(agrees(TypeParam::leftJacobian(tangent), (moved * back).log())) << tangent.transpose();
    ASSERT_TRUE(agrees(TypeParam::rightJacobian(tangent), (back * moved).log())) << tangent.transpose();
    ++num_checked;
  }
  EXPECT_EQ(num_checked, kNumAllTangents<TypeParam> + kNumBeyondPi);
}

TYPED_TEST(GroupJacobians, InversesAreThoseOfLog) {
  using JetGroup = JetGroupOf<TypeParam>;
  using Jet = JetOf<TypeParam>;
  const JetGroup step = JetGroup::exp(perturbation<TypeParam>());
  int num_checked = 0;
  for (const auto& tangent : allTangents<TypeParam>()) {
    const TypeParam at = TypeParam::exp(tangent);
    const typename TypeParam::Tangent log = at.log();  // at a half turn, one of two
    const JetGroup x = at.template cast<Jet>();
    ASSERT_TRUE(agrees(TypeParam::leftJacobianInverse(log), (step * x).log())) << tangent.transpose();
    ASSERT_TRUE(agrees(TypeParam::rightJacobianInverse(log), (x * step).log())) << tangent.transpose();
    ++num_checked;
  }
  EXPECT_EQ(num_checked, kNumAllTangents<TypeParam>);
}

TYPED_TEST(GroupJacobians, InversesUndo) {
  const auto identity = JacobianOf<TypeParam>::Identity();
  int num_checked = 0;
  for (const auto& tangent : tangentsBeyondPi<TypeParam>()) {
    ASSERT_TRUE(isNear(TypeParam::leftJacobian(tangent) * TypeParam::leftJacobianInverse(tangent), identity,
                       kInverseTolerance * (1.0 + TypeParam::leftJacobianInverse(tangent).norm())))
        << tangent.transpose();
    ASSERT_TRUE(isNear(TypeParam::rightJacobian(tangent) * TypeParam::rightJacobianInverse(tangent), identity,
                       kInverseTolerance * (1.0 + TypeParam::rightJacobianInverse(tangent).norm())))
        << tangent.transpose();
    ++num_checked;
  }
  EXPECT_EQ(num_checked, kNumAllTangents<TypeParam> + kNumBeyondPi);
}

TYPED_TEST(GroupJacobians, LeftIsTheAdjointOfRight) {
  int num_checked = 0;
  for (const auto& tangent : allTangents<TypeParam>()) {
    ASSERT_TRUE(isNear(TypeParam::leftJacobian(tangent),
                       TypeParam::exp(tangent).adjoint() * TypeParam::rightJacobian(tangent),
                       kInverseTolerance));
    ++num_checked;
  }
  EXPECT_EQ(num_checked, kNumAllTangents<TypeParam>);
}

TYPED_TEST(GroupJacobians, AreContinuousAcrossTheSwitchOfFormula) {
  constexpr double kStep = 4e-16;  // a few units in the last place of the angle
  int num_checked = 0;
  for (const double angle : {kJacobianSwitchAngle, kExpSwitchAngle}) {
    for (const Eigen::Vector3d& axis : hardAxes()) {
      typename TypeParam::Tangent below = TypeParam::Tangent::Constant(0.1);
      typename TypeParam::Tangent above = below;
      below.template tail<3>() = angle * (1.0 - kStep) * axis;
      above.template tail<3>() = angle * (1.0 + kStep) * axis;
      const double tolerance = kSwitchTolerance + 2.0 * angle * kStep;
      ASSERT_TRUE(isNear(TypeParam::exp(below).matrix(), TypeParam::exp(above).matrix(), tolerance));
      ASSERT_TRUE(isNear(TypeParam::leftJacobian(below), TypeParam::leftJacobian(above), tolerance));
      ASSERT_TRUE(
          isNear(TypeParam::leftJacobianInverse(below), TypeParam::leftJacobianInverse(above), tolerance));
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 2 * 10);
}

TYPED_TEST(GroupJacobians, AreTheIdentityAtZero) {
  const typename TypeParam::Tangent zero = TypeParam::Tangent::Zero();
  const auto identity = JacobianOf<TypeParam>::Identity();
  EXPECT_TRUE(isNear(TypeParam::leftJacobian(zero), identity, 0.0));
  EXPECT_TRUE(isNear(TypeParam::rightJacobian(zero), identity, 0.0));
  EXPECT_TRUE(isNear(TypeParam::leftJacobianInverse(zero), identity, 0.0));
  EXPECT_TRUE(isNear(TypeParam::rightJacobianInverse(zero), identity, 0.0));
}

TYPED_TEST(GroupJacobians, RightPerturbationMovesAPointInTheSourceFrame) {
  // X exp(d) p = X (p + w x p + v): the derivative is R [I, -hat(p)], for SO(3) its right half.
  using JetGroup = JetGroupOf<TypeParam>;
  using Jet = JetOf<TypeParam>;
  const JetGroup step = JetGroup::exp(perturbation<TypeParam>());
  Random random(32);
  int num_checked = 0;
  for (const auto& tangent : allTangents<TypeParam>()) {
    const TypeParam x = TypeParam::exp(tangent);
    const Eigen::Vector3d p = randomVector(random, -3.0, 3.0);
    const Eigen::Matrix3d R = rotationOf(x).matrix();
    Eigen::Matrix<double, 3, 6> expected;
    expected << R, -R * hat(p);
    const Eigen::Matrix<Jet, 3, 1> moved = x.template cast<Jet>() * step * p.template cast<Jet>();
    ASSERT_TRUE(
        isNear(derivative(moved), expected.rightCols<TypeParam::kDim>(), kJetTolerance * (1.0 + p.norm())));
    ++num_checked;
  }
  EXPECT_EQ(num_checked, kNumAllTangents<TypeParam>);
}

}  // namespace
}  // namespace alidade
