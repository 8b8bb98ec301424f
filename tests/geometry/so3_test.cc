// SPDX-License-Identifier: MIT
#include "alidade/geometry/so3.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "alidade/core/error.h"
#include "alidade/core/random.h"
#include "geometry/group_cases.h"
#include "geometry/matrix_near.h"

namespace alidade {
namespace {

constexpr double kTolerance = 1e-15;  // two or three roundings of numbers up to 1
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(Hat, IsTheCrossProduct) {
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d a = randomVector(random, -1.0, 1.0);
    const Eigen::Vector3d b = randomVector(random, -1.0, 1.0);
    ASSERT_TRUE(isNear(hat(a) * b, a.cross(b), kTolerance));
  }
}

TEST(So3Quaternion, IsNormalised) {
  const SO3 rotation = SO3::fromQuaternion(Eigen::Quaterniond(-3.0, 0.5, 2.0, -7.0));
  EXPECT_NEAR(rotation.quaternion().norm(), 1.0, kTolerance);
  EXPECT_TRUE(isNear(rotation.matrix(),
                     Eigen::Quaterniond(-3.0, 0.5, 2.0, -7.0).normalized().toRotationMatrix(), kTolerance));
}

TEST(So3Quaternion, OppositeSignIsTheSameRotation) {
  const Eigen::Quaterniond q(0.3, 0.5, 2.0, -7.0);
  const SO3 a = SO3::fromQuaternion(q);
  const SO3 b = SO3::fromQuaternion(Eigen::Quaterniond(-q.w(), -q.x(), -q.y(), -q.z()));
  EXPECT_TRUE(isNear(a.matrix(), b.matrix(), 0.0));
  EXPECT_TRUE(isNear(a.log(), b.log(), 0.0));
}

TEST(So3Quaternion, WithoutADirectionIsRejected) {
  for (const Eigen::Quaterniond& q :
       {Eigen::Quaterniond(0.0, 0.0, 0.0, 0.0), Eigen::Quaterniond(1e-200, 0.0, 0.0, 0.0),
        Eigen::Quaterniond(kNaN, 0.0, 0.0, 1.0), Eigen::Quaterniond(1.0, 0.0, kInfinity, 0.0)}) {
    try {
      const SO3 rotation = SO3::fromQuaternion(q);
      ADD_FAILURE() << "accepted " << rotation.quaternion().coeffs().transpose();
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kInput);
    }
  }
}

TEST(So3Quaternion, WithoutADirectionIsNaNAmongAutomaticDerivatives) {
  using Jet = ceres::Jet<double, 1>;
  const Jet zero(0.0);
  const auto rotation = BasicSO3<Jet>::fromQuaternion(Eigen::Quaternion<Jet>(zero, zero, zero, zero));
  const auto R = rotation.matrix();
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(std::isnan(R(i, i).a));
}

TEST(So3Exp, TurnsRightHanded) {
  const SO3 quarter = SO3::exp(Eigen::Vector3d(0.0, 0.0, kPi / 2));
  EXPECT_TRUE(isNear(quarter * Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), kTolerance));
}

TEST(So3Exp, AgreesWithAngleAxisBeyondOneTurn) {
  constexpr double kAngleTolerance = 1e-14;  // the angle itself is rounded to 2e-15 near 20
  Random random(2);
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3d w = randomRotationVector(random, 20.0);
    const Eigen::AngleAxisd expected(w.norm(), w.normalized());
    ASSERT_TRUE(isNear(SO3::exp(w).matrix(), expected.toRotationMatrix(), kAngleTolerance));
  }
}

TEST(So3Log, KeepsTheDigitsOfATinyRotation) {
  const Eigen::Vector3d w(1e-9, -3e-12, 2e-10);
  EXPECT_TRUE(isNear(SO3::exp(w).log(), w, 1e-16 * w.norm() * 4));
}

TEST(So3Log, IsContinuousAcrossTheSwitchOfFormula) {
  constexpr double kStep = 1e-15;
  for (const Eigen::Vector3d& axis : hardAxes()) {
    for (const double angle : {kLogSwitchAngle - kStep, kLogSwitchAngle, kLogSwitchAngle + kStep}) {
      ASSERT_TRUE(isNear(SO3::exp(angle * axis).log(), angle * axis, 1e-17));
    }
  }
}

TEST(So3Log, OfAnExactHalfTurnStartsWithAPositiveComponent) {
  struct Case {
    Eigen::Vector3d given;
    Eigen::Vector3d axis;
  };
  const Eigen::Vector3d general = Eigen::Vector3d(0.0, 0.6, -0.8);
  for (const auto& [given, axis] : {Case{Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitX()},
                                    Case{-Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitX()},
                                    Case{-Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitY()},
                                    Case{-Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitZ()},
                                    Case{general, general}, Case{-general, general}}) {
    for (const double zero : {0.0, -0.0}) {
      const Eigen::Quaterniond half_turn(zero, given.x(), given.y(), given.z());
      EXPECT_TRUE(isNear(SO3::fromQuaternion(half_turn).log(), kPi * axis, kTolerance)) << given.transpose();
    }
  }
}

TEST(So3Log, PassesNaNOn) {
  EXPECT_TRUE(SO3::exp(Eigen::Vector3d(0.0, kNaN, 0.0)).log().array().isNaN().any());
}

TEST(So3Jets, ProductOfConstantsHasNoDerivative) {
  using Jet = ceres::Jet<double, 3>;
  const auto a = SO3::exp(Eigen::Vector3d(0.1, 0.2, 0.3)).cast<Jet>();
  const Eigen::Matrix<Jet, 3, 1> w = (a * a.inverse()).log();
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(w[i].a, 0.0, kTolerance);
    EXPECT_TRUE(isNear(w[i].v, Eigen::Vector3d::Zero(), 0.0));
  }
}

}  // namespace
}  // namespace alidade
