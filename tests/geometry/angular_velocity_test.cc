// SPDX-License-Identifier: MIT
#include "alidade/geometry/angular_velocity.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "alidade/core/error.h"
#include "alidade/core/random.h"
#include "geometry/group_cases.h"
#include "geometry/matrix_near.h"

namespace alidade {
namespace {

constexpr double kTolerance = 1e-13;  // roundings of rates up to about 10 rad/s
constexpr int kNumMotions = 300;

/// fixed_from_body(t) = exp(sin(t) a) exp(t^2 b): two axes, so that it has a different rate at every time, in
/// each of the frames.
struct Motion {
  Eigen::Vector3d a;
  Eigen::Vector3d b;

  template <class T>
  BasicSO3<T> at(const T& t) const {
    using std::sin;
    const Eigen::Matrix<T, 3, 1> first = sin(t) * a.cast<T>();
    const Eigen::Matrix<T, 3, 1> second = t * t * b.cast<T>();
    return BasicSO3<T>::exp(first) * BasicSO3<T>::exp(second);
  }

  /// The rates of the two turns add, the second one carried along by the first.
  [[nodiscard]] Eigen::Vector3d rateInFixed(double t) const {
    return std::cos(t) * a + 2.0 * t * (SO3::exp(std::sin(t) * a) * b);
  }

  [[nodiscard]] Eigen::Matrix3d derivative(double t) const {
    using Jet = ceres::Jet<double, 1>;
    const Eigen::Matrix<Jet, 3, 3> R = at(Jet(t, 0)).matrix();
    return R.unaryExpr([](const Jet& entry) { return entry.v[0]; });
  }
};

Motion randomMotion(Random& random) {
  const Eigen::Vector3d a = randomVector(random, -1.5, 1.5);
  return {a, randomVector(random, -1.5, 1.5)};
}

TEST(AngularVelocity, IsThatOfATimeParametrisedRotation) {
  Random random(51);
  for (int i = 0; i < kNumMotions; ++i) {
    const Motion motion = randomMotion(random);
    const double t = i == 0 ? 0.0 : random.uniform(-1.5, 1.5);
    const SO3 fixed_from_body = motion.at(t);
    const Eigen::Matrix3d derivative = motion.derivative(t);
    const Eigen::Vector3d rate = motion.rateInFixed(t);
    ASSERT_TRUE(isNear(angularVelocity(fixed_from_body, derivative), rate, kTolerance));
    ASSERT_TRUE(isNear(bodyAngularVelocity(fixed_from_body, derivative), fixed_from_body.inverse() * rate,
                       kTolerance));
  }
}

TEST(AngularVelocity, MovesAVectorHeldInTheBody) {
  Random random(52);
  for (int i = 0; i < kNumMotions; ++i) {
    const Motion motion = randomMotion(random);
    const double t = random.uniform(-1.5, 1.5);
    const Eigen::Vector3d p_body = randomVector(random, -1.0, 1.0);
    const Eigen::Matrix3d derivative = motion.derivative(t);
    const Eigen::Vector3d omega = angularVelocity(motion.at(t), derivative);
    ASSERT_TRUE(isNear(omega.cross(motion.at(t) * p_body), derivative * p_body, kTolerance));
  }
}

TEST(AngularVelocity, AcceptsCentralDifferences) {
  constexpr double kStep = 1e-4;
  constexpr double kDifferenceTolerance = 1e-6;  // step^2 / 6 times the third derivative, at most 100 here
  Random random(53);
  for (int i = 0; i < kNumMotions; ++i) {
    const Motion motion = randomMotion(random);
    const double t = random.uniform(-1.5, 1.5);
    const Eigen::Matrix3d derivative =
        (motion.at(t + kStep).matrix() - motion.at(t - kStep).matrix()) / (2.0 * kStep);
    ASSERT_TRUE(isNear(angularVelocity(motion.at(t), derivative, kDifferenceTolerance), motion.rateInFixed(t),
                       kDifferenceTolerance));
  }
}

TEST(AngularVelocity, OfARotationAtRestIsZero) {
  const SO3 rotation = SO3::exp(Eigen::Vector3d(0.1, 0.2, 0.3));
  EXPECT_TRUE(isNear(angularVelocity(rotation, Eigen::Matrix3d::Zero()), Eigen::Vector3d::Zero(), 0.0));
}

TEST(AngularVelocity, RejectsWhatIsNotTheDerivativeOfThisRotation) {
  const Motion motion{Eigen::Vector3d(0.5, -1.0, 0.7), Eigen::Vector3d(0.2, 0.9, -0.4)};
  const SO3 rotation = motion.at(0.6);
  const Eigen::Matrix3d derivative = motion.derivative(0.6);
  EXPECT_NO_THROW((void)angularVelocity(rotation, derivative));
  EXPECT_THROW((void)angularVelocity(rotation.inverse(), derivative), Error);
  EXPECT_THROW((void)angularVelocity(motion.at(0.7), derivative), Error);
  EXPECT_THROW((void)bodyAngularVelocity(rotation, derivative.transpose()), Error);
  Eigen::Matrix3d with_nan = derivative;
  with_nan(1, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW((void)angularVelocity(rotation, with_nan), Error);
}

}  // namespace
}  // namespace alidade
