// SPDX-License-Identifier: MIT
#include "alidade/geometry/rotation_conversions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "alidade/core/error.h"
#include "alidade/core/random.h"
#include "geometry/group_cases.h"
#include "geometry/matrix_near.h"

namespace alidade {
namespace {

using testing::HasSubstr;

constexpr double kTolerance = 2e-15;     // a few roundings of the entries of a rotation matrix
constexpr double kLockTolerance = 2e-8;  // the documented 1e-8 rad, in two entries at once
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr int kNumRandom = 2000;

/// The message of the Error that `call` throws; empty if it throws none.
template <class Call>
std::string messageOf(Call call) {
  try {
    (void)call();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInput);
    return error.what();
  }
  return "";
}

std::string rotationFault(const Eigen::Matrix3d& R) {
  return messageOf([&] { return rotationFromMatrix(R); });
}

TEST(RotationFromMatrix, UndoesMatrix) {
  int num_checked = 0;
  for (const auto& w : allTangents<SO3>()) {
    const Eigen::Matrix3d R = SO3::exp(w).matrix();
    ASSERT_TRUE(isNear(rotationFromMatrix(R).matrix(), R, kTolerance));
    ++num_checked;
  }
  EXPECT_EQ(num_checked, kNumAllTangents<SO3>);
}

TEST(RotationFromMatrix, OfAnExactHalfTurnHasAnAngleOfPi) {
  const Eigen::Vector3d diagonal(-1.0, 1.0, -1.0);
  EXPECT_TRUE(isNear(rotationFromMatrix(diagonal.asDiagonal()).log(), Eigen::Vector3d(0.0, kPi, 0.0), 1e-15));
}

TEST(RotationFromMatrix, TakesTheNearestRotationOfARoundedMatrix) {
  constexpr double kRounding = 1e-7;  // seven decimals
  Random random(61);
  for (int i = 0; i < kNumRandom; ++i) {
    const Eigen::Matrix3d R = SO3::exp(randomRotationVector(random)).matrix();
    const Eigen::Matrix3d rounded = (R / kRounding).array().round().matrix() * kRounding;
    const Eigen::Matrix3d nearest = rotationFromMatrix(rounded).matrix();
    ASSERT_TRUE(isNear(nearest.transpose() * nearest, Eigen::Matrix3d::Identity(), kTolerance));
    ASSERT_LE((nearest - rounded).norm(), (R - rounded).norm() + kTolerance);
    // What is nearest leaves a symmetric remainder: any turn would move further away.
    const Eigen::Matrix3d left = nearest.transpose() * rounded;
    ASSERT_TRUE(isNear(left, left.transpose(), 2 * kTolerance));
  }
}

TEST(RotationFromMatrix, NamesWhatIsWrong) {
  const Eigen::Matrix3d good = SO3::exp(Eigen::Vector3d(0.3, -0.2, 0.5)).matrix();
  EXPECT_EQ(rotationFault(good), "");

  Eigen::Matrix3d bad = good;
  bad.col(1) *= 1.001;
  EXPECT_THAT(rotationFault(bad), HasSubstr("column 1 has length 1.00"));

  bad = good;
  bad.col(2) = (good.col(2) + 0.01 * good.col(0)).normalized();
  EXPECT_THAT(rotationFault(bad), HasSubstr("columns 0 and 2 are not perpendicular"));

  bad = good;
  bad.col(0) *= -1.0;
  EXPECT_THAT(rotationFault(bad), HasSubstr("reflection"));

  bad = good;
  bad(2, 1) = kNaN;
  EXPECT_THAT(rotationFault(bad), HasSubstr("not a finite number"));

  EXPECT_THAT(rotationFault(Eigen::Matrix3d::Zero()), HasSubstr("column 0 has length 0"));
}

TEST(RotationFromMatrix, ToleranceIsTheBound) {
  const Eigen::Matrix3d identity = Eigen::Matrix3d::Identity();
  EXPECT_EQ(rotationFault((1.0 + 0.4 * kRotationTolerance) * identity), "");
  EXPECT_NE(rotationFault((1.0 + 0.6 * kRotationTolerance) * identity), "");
  EXPECT_NO_THROW((void)rotationFromMatrix(1.001 * identity, 0.01));
  EXPECT_THROW((void)rotationFromMatrix(identity, 0.0), std::logic_error);
  EXPECT_THROW((void)rotationFromMatrix(identity, kNaN), std::logic_error);
}

TEST(MotionFromMatrix, UndoesMatrix) {
  int num_checked = 0;
  for (const auto& xi : allTangents<SE3>()) {
    const SE3 x = SE3::exp(xi);
    ASSERT_TRUE(isNear(motionFromMatrix(x.matrix()).matrix(), x.matrix(), kTolerance));
    ++num_checked;
  }
  EXPECT_EQ(num_checked, kNumAllTangents<SE3>);
}

TEST(MotionFromMatrix, NamesWhatIsWrong) {
  SE3::Tangent xi;
  xi << 1.0, 2.0, 3.0, 0.4, 0.5, 0.6;
  const Eigen::Matrix4d good = SE3::exp(xi).matrix();
  const auto fault = [](const Eigen::Matrix4d& m) { return messageOf([&] { return motionFromMatrix(m); }); };
  EXPECT_EQ(fault(good), "");
  EXPECT_THAT(fault(good.transpose()), HasSubstr("last row"));

  Eigen::Matrix4d bad = good;
  bad(3, 3) = kNaN;
  EXPECT_THAT(fault(bad), HasSubstr("last row"));

  bad = good;
  bad(1, 3) = kNaN;
  EXPECT_THAT(fault(bad), HasSubstr("translation"));

  bad = good;
  bad.topLeftCorner<3, 3>() *= 1.001;
  EXPECT_THAT(fault(bad), HasSubstr("column 0 has length 1.00"));
}

TEST(RotationFromEuler, TurnsAboutXThenYThenZ) {
  using Eigen::AngleAxisd;
  Random random(62);
  for (int i = 0; i < kNumRandom; ++i) {
    const Eigen::Vector3d e(random.uniform(-4.0, 4.0), random.uniform(-4.0, 4.0), random.uniform(-4.0, 4.0));
    const Eigen::Matrix3d expected =
        (AngleAxisd(e[0], Eigen::Vector3d::UnitZ()) * AngleAxisd(e[1], Eigen::Vector3d::UnitY()) *
         AngleAxisd(e[2], Eigen::Vector3d::UnitX()))
            .toRotationMatrix();
    ASSERT_TRUE(isNear(rotationFromEuler(e).matrix(), expected, kTolerance));
  }
}

TEST(RotationFromEuler, RejectsWhatIsNotFinite) {
  EXPECT_THROW((void)rotationFromEuler({kNaN, 0.0, 0.0}), Error);
  EXPECT_THROW((void)rotationFromEuler({0.0, 0.0, std::numeric_limits<double>::infinity()}), Error);
}

TEST(EulerFromRotation, RoundTripsTheAngles) {
  constexpr double kAngleTolerance = 1e-13;  // a rounding over the cosine of the pitch, which is 0.01 or more
  Random random(63);
  for (int i = 0; i < kNumRandom; ++i) {
    const Eigen::Vector3d e(random.uniform(-kPi, kPi), random.uniform(-1.56, 1.56),
                            random.uniform(-kPi, kPi));
    const auto [angles, gimbal_lock] = eulerFromRotation(rotationFromEuler(e));
    ASSERT_FALSE(gimbal_lock);
    ASSERT_NEAR(angles[0], e[0], kAngleTolerance);
    ASSERT_NEAR(angles[1], e[1], kAngleTolerance);
    ASSERT_NEAR(angles[2], e[2], kAngleTolerance);
  }
}

TEST(EulerFromRotation, RecomposesAnyRotation) {
  int num_checked = 0;
  for (const auto& w : allTangents<SO3>()) {
    const SO3 rotation = SO3::exp(w);
    const auto [angles, gimbal_lock] = eulerFromRotation(rotation);
    ASSERT_TRUE(isNear(rotationFromEuler(angles).matrix(), rotation.matrix(),
                       gimbal_lock ? kLockTolerance : kTolerance))
        << w.transpose();
    ++num_checked;
  }
  EXPECT_EQ(num_checked, kNumAllTangents<SO3>);
}

TEST(EulerFromRotation, RecomposesUpToTheEdgeOfTheLock) {
  Random random(64);
  int num_checked = 0;
  for (const double from_pole : {1e-2, 1e-4, 1e-6, 2e-8}) {
    for (const double sign : {-1.0, 1.0}) {
      for (int i = 0; i < 100; ++i) {
        const Eigen::Vector3d e(random.uniform(-kPi, kPi), sign * (kPi / 2 - from_pole),
                                random.uniform(-kPi, kPi));
        const SO3 rotation = rotationFromEuler(e);
        const auto [angles, gimbal_lock] = eulerFromRotation(rotation);
        ASSERT_FALSE(gimbal_lock);
        ASSERT_TRUE(isNear(rotationFromEuler(angles).matrix(), rotation.matrix(), kTolerance));
        ++num_checked;
      }
    }
  }
  EXPECT_EQ(num_checked, 4 * 2 * 100);
}

TEST(EulerFromRotation, ReportsGimbalLock) {
  Random random(65);
  int num_checked = 0;
  for (const double from_pole : {0.0, 1e-12, 5e-9}) {
    for (const double sign : {-1.0, 1.0}) {
      for (int i = 0; i < 100; ++i) {
        const Eigen::Vector3d e(random.uniform(-1.5, 1.5), sign * (kPi / 2 - from_pole),
                                random.uniform(-1.5, 1.5));
        const SO3 rotation = rotationFromEuler(e);
        const auto [angles, gimbal_lock] = eulerFromRotation(rotation);
        ASSERT_TRUE(gimbal_lock);
        ASSERT_EQ(angles[2], 0.0);
        ASSERT_NEAR(angles[1], e[1], kTolerance);
        ASSERT_NEAR(angles[0], e[0] - sign * e[2], kTolerance);
        ASSERT_TRUE(
            isNear(rotationFromEuler(angles).matrix(), rotation.matrix(), 2 * from_pole + kTolerance));
        ++num_checked;
      }
    }
  }
  EXPECT_EQ(num_checked, 3 * 2 * 100);
}

// The letters of all 12 orders.
std::vector<std::string> allOrders() {
  std::vector<std::string> orders;
  for (const char a : {'x', 'y', 'z'}) {
    for (const char b : {'x', 'y', 'z'}) {
      for (const char c : {'x', 'y', 'z'}) {
        if (a != b && b != c) orders.push_back({a, b, c});
      }
    }
  }
  return orders;
}

TEST(EulerOrder, HasTwelveOrdersOfNeighboursThatDiffer) {
  EXPECT_EQ(allOrders().size(), 12u);
  for (const std::string& letters : allOrders()) EXPECT_TRUE(eulerOrder(letters)) << letters;
  for (const char* letters : {"", "zy", "zzx", "zyy", "zyxz", "ZYX", "abc", "wxy"})
    EXPECT_FALSE(eulerOrder(letters)) << letters;
}

TEST(EulerOrder, TurnsAboutMovingOrFixedAxes) {
  using Eigen::AngleAxisd;
  Random random(66);
  int num_checked = 0;
  for (const std::string& letters : allOrders()) {
    const Eigen::Vector3d e = randomVector(random, -4.0, 4.0);
    std::array<Eigen::Matrix3d, 3> turns;
    for (std::size_t i = 0; i < 3; ++i)
      turns[i] =
          AngleAxisd(e[static_cast<int>(i)], Eigen::Vector3d::Unit(letters[i] - 'x')).toRotationMatrix();
    EXPECT_TRUE(isNear(rotationFromEuler(e, *eulerOrder(letters)).matrix(), turns[0] * turns[1] * turns[2],
                       kTolerance));
    EXPECT_TRUE(isNear(rotationFromEuler(e, *eulerOrder(letters, true)).matrix(),
                       turns[2] * turns[1] * turns[0], kTolerance));
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 12);
}

TEST(EulerOrder, RecomposesAnyRotationWithAnglesInTheirRanges) {
  int num_checked = 0;
  int num_locks = 0;
  for (const std::string& letters : allOrders()) {
    for (const bool is_fixed : {false, true}) {
      const EulerOrder order = *eulerOrder(letters, is_fixed);
      for (const auto& w : allTangents<SO3>()) {
        const SO3 rotation = SO3::exp(w);
        const auto [angles, gimbal_lock] = eulerFromRotation(rotation, order);
        ASSERT_TRUE(isNear(rotationFromEuler(angles, order).matrix(), rotation.matrix(),
                           gimbal_lock ? kLockTolerance : 2 * kTolerance))
            << letters << " " << w.transpose();
        const double least = letters[0] == letters[2] ? 0.0 : -kPi / 2;
        ASSERT_TRUE(angles[1] >= least && angles[1] <= least + kPi);
        if (gimbal_lock) {
          ASSERT_EQ(angles[is_fixed ? 0 : 2], 0.0);
        }
        num_locks += gimbal_lock ? 1 : 0;
        ++num_checked;
      }
    }
  }
  EXPECT_EQ(num_checked, 24 * kNumAllTangents<SO3>);
  EXPECT_GT(num_locks, 24 * 10);
}

TEST(MeanPose, IsWhereTheTurnsCancel) {
  Random random(67);
  std::vector<SE3> poses;
  const SE3 truth = SE3::exp(randomTangent<SE3>(random));
  for (int i = 0; i < 40; ++i) {
    const SE3::Tangent away = 0.3 * randomTangent<SE3>(random, 1.0);
    for (const double sign : {-1.0, 1.0}) {
      poses.push_back(
          {truth.rotation * SO3::exp(sign * away.tail<3>()), truth.translation + sign * away.head<3>()});
    }
  }
  const PoseMean mean = meanPose(poses);
  EXPECT_TRUE(isNear(mean.mean.matrix(), truth.matrix(), 1e-13));
  double squares = 0;
  double largest = 0;
  for (const SE3& pose : poses) {
    const double angle = (truth.rotation.inverse() * pose.rotation).log().norm();
    squares += angle * angle;
    largest = std::max(largest, angle);
  }
  EXPECT_NEAR(mean.rms_rad, std::sqrt(squares / 80), 1e-12);
  EXPECT_NEAR(mean.max_rad, largest, 1e-12);
  EXPECT_GT(mean.rms_m, 0.1);
}

TEST(MeanPose, IsTheKarcherMeanOfUnevenTurns) {
  const auto turned = [](double angle) { return SE3{SO3::exp({0, 0, angle}), Eigen::Vector3d::Zero()}; };
  const std::vector<SE3> poses = {turned(0), turned(0), turned(1.2)};
  const PoseMean mean = meanPose(poses);
  EXPECT_TRUE(isNear(mean.mean.rotation.log(), Eigen::Vector3d(0, 0, 0.4), 1e-14));
  EXPECT_NEAR(mean.rms_rad, std::sqrt((2 * 0.16 + 0.64) / 3), 1e-14);
  EXPECT_EQ(meanPose(std::vector<SE3>{turned(3.0)}).rms_rad, 0.0);
}

TEST(RotationAxis, IsTheEigenvectorOfEigenvalueOne) {
  int num_axes = 0;
  int num_identities = 0;
  for (const auto& w : allTangents<SO3>()) {
    const Eigen::Matrix3d R = SO3::exp(w).matrix();
    const auto axis = rotationAxis(R);
    if (w.norm() < 1e-15) {
      ASSERT_FALSE(axis.has_value());
      ++num_identities;
      continue;
    }
    ASSERT_TRUE(axis.has_value());
    ASSERT_NEAR(axis->norm(), 1.0, kTolerance);
    ASSERT_TRUE(isNear(R * *axis, *axis, kTolerance));
    ++num_axes;
  }
  EXPECT_EQ(num_axes + num_identities, kNumAllTangents<SO3>);
  EXPECT_EQ(num_identities, 2 * 10);
}

TEST(RotationAxis, PointsAlongTheRotationVector) {
  int num_checked = 0;
  for (const auto& w : allTangents<SO3>()) {
    if (w.norm() < 1e-15 || w.norm() > kPi - 1e-12) continue;
    const auto axis = rotationAxis(SO3::exp(w).matrix());
    ASSERT_TRUE(axis.has_value());
    ASSERT_TRUE(isNear(*axis, w.normalized(), kTolerance / std::min(1.0, w.norm()))) << w.transpose();
    ++num_checked;
  }
  EXPECT_EQ(num_checked, kNumAllTangents<SO3> - 3 * 10);
}

TEST(RotationAxis, OfAnExactHalfTurnHasTheSignOfLog) {
  for (const Eigen::Vector3d& given : hardAxes()) {
    const Eigen::Matrix3d R = 2.0 * given * given.transpose() - Eigen::Matrix3d::Identity();
    const auto axis = rotationAxis(R);
    ASSERT_TRUE(axis.has_value());
    EXPECT_TRUE(isNear(kPi * *axis, rotationFromMatrix(R).log(), 1e-14));
  }
}

TEST(RotationAxis, RejectsWhatIsNotARotation) {
  EXPECT_THROW((void)rotationAxis(-Eigen::Matrix3d::Identity()), Error);
  EXPECT_THROW((void)rotationAxis(Eigen::Matrix3d::Zero()), Error);
}

}  // namespace
}  // namespace alidade
