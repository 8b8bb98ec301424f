// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <type_traits>
#include <vector>

#include "alidade/core/random.h"
#include "alidade/geometry/se3.h"
#include "alidade/geometry/so3.h"

namespace alidade {

inline constexpr double kPi = std::numbers::pi;
inline constexpr double kNearAngle = 1e-9;  // below it, one minus the cosine is lost to rounding
inline const double kLogSwitchAngle = 2.0 * std::atan(0.01);
inline constexpr double kJacobianSwitchAngle = 1.0;
inline constexpr double kExpSwitchAngle = 2.0;

/// Rotation angles in [0, pi] where a formula is at its worst: the singular points, and both sides of each
/// switch between a series and a closed form.
inline std::vector<double> hardAngles() {
  return {0.0,
          1e-200,
          kNearAngle,
          kLogSwitchAngle - kNearAngle,
          kLogSwitchAngle + kNearAngle,
          kJacobianSwitchAngle - kNearAngle,
          kJacobianSwitchAngle + kNearAngle,
          kPi / 2,
          kExpSwitchAngle - kNearAngle,
          kExpSwitchAngle + kNearAngle,
          kPi - 1e-3,
          kPi - kNearAngle,
          kPi};
}

inline std::vector<Eigen::Vector3d> hardAxes() {
  using Vec3 = Eigen::Vector3d;
  return {Vec3::UnitX(),
          -Vec3::UnitX(),
          Vec3::UnitY(),
          -Vec3::UnitY(),
          Vec3::UnitZ(),
          -Vec3::UnitZ(),
          Vec3(1.0, 1.0, 0.0).normalized(),
          Vec3(0.0, -1.0, 1.0).normalized(),
          Vec3(1.0, 2.0, 3.0).normalized(),
          Vec3(-3.0, 1e-8, 0.5).normalized()};
}

inline Eigen::Vector3d randomVector(Random& random, double low, double high) {
  const double x = random.uniform(low, high);
  const double y = random.uniform(low, high);
  const double z = random.uniform(low, high);
  return {x, y, z};
}

/// A direction uniform on the sphere times a length uniform in [0, max_angle).
inline Eigen::Vector3d randomRotationVector(Random& random, double max_angle = kPi) {
  const double x = random.normal();
  const double y = random.normal();
  const double z = random.normal();
  return random.uniform(0.0, max_angle) * Eigen::Vector3d(x, y, z).normalized();
}

template <class Group>
constexpr bool kHasTranslation = std::is_same_v<Group, SE3>;

/// Every hard angle about every hard axis, for SE(3) each with translations of three sizes.
template <class Group>
std::vector<typename Group::Tangent> hardTangents() {
  std::vector<typename Group::Tangent> tangents;
  for (const double angle : hardAngles()) {
    for (const Eigen::Vector3d& axis : hardAxes()) {
      if constexpr (kHasTranslation<Group>) {
        for (const double size : {0.0, 1e-9, 2.0}) {
          SE3::Tangent xi;
          xi << size * Eigen::Vector3d(0.3, -1.0, 0.6), angle * axis;
          tangents.push_back(xi);
        }
      } else {
        tangents.push_back(angle * axis);
      }
    }
  }
  return tangents;
}

template <class Group>
typename Group::Tangent randomTangent(Random& random, double max_angle = kPi) {
  if constexpr (kHasTranslation<Group>) {
    SE3::Tangent xi;
    xi.tail<3>() = randomRotationVector(random, max_angle);
    xi.head<3>() = randomVector(random, -2.0, 2.0);
    return xi;
  } else {
    return randomRotationVector(random, max_angle);
  }
}

/// The hard tangents and then random ones.
template <class Group>
std::vector<typename Group::Tangent> allTangents() {
  constexpr int kNumRandom = 300;
  std::vector<typename Group::Tangent> tangents = hardTangents<Group>();
  Random random(11);
  for (int i = 0; i < kNumRandom; ++i) tangents.push_back(randomTangent<Group>(random));
  return tangents;
}

/// How many allTangents() there are, counted by hand: an empty loop is not a passed test.
template <class Group>
constexpr int kNumAllTangents = 13 * 10 * (kHasTranslation<Group> ? 3 : 1) + 300;

inline SO3 rotationOf(const SO3& x) {
  return x;
}
inline SO3 rotationOf(const SE3& x) {
  return x.rotation;
}
inline Eigen::Vector3d rotationPart(const SO3::Tangent& w) {
  return w;
}
inline Eigen::Vector3d rotationPart(const SE3::Tangent& xi) {
  return xi.tail<3>();
}

}  // namespace alidade
