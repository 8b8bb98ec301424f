// SPDX-License-Identifier: MIT
#include "alidade/simulate/footage_motion.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "alidade/core/random.h"

namespace alidade {
namespace {

using Eigen::Vector3d;

// `slow` is the lowest frequency; the others are about 1.6 and 2.6 times as high, with smaller amplitudes.
SmoothCurve randomCurve(const Vector3d& amplitude, double slow, Random& random) {
  constexpr std::array<double, 3> kShares = {0.6, 0.28, 0.12};
  SmoothCurve curve;
  double frequency = slow;
  for (std::size_t k = 0; k < kShares.size(); ++k, frequency *= std::numbers::phi) {
    curve.amplitudes[k] = kShares[k] * amplitude;
    for (int i = 0; i < 3; ++i) {
      curve.frequencies[k][i] = frequency * random.uniform(0.9, 1.1);
      curve.phases[k][i] = random.uniform(0, 2 * std::numbers::pi);
    }
  }
  return curve;
}

}  // namespace

Vector3d SmoothCurve::at(double parameter) const {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t k = 0; k < amplitudes.size(); ++k) {
    const Vector3d angle = parameter * frequencies[k] + phases[k];
    sum +=
        amplitudes[k].cwiseProduct(Vector3d(std::sin(angle.x()), std::sin(angle.y()), std::sin(angle.z())));
  }
  return sum;
}

FootageMotion::FootageMotion(const FootageScene& scene, double focal_px) : path_(scene.path) {
  Random random(streamSeed(scene.seed, 1));
  const bool is_before_plane = scene.surroundings == FootageSurroundings::kPlane;
  if (path_ == FootagePath::kWalk) {
    position_ = randomCurve({1.1, 0.25, 1.0}, 0.8, random);
    turn_ = randomCurve(Vector3d(0.2, 0.6, 0.15) * (is_before_plane ? 0.5 : 1), 0.6, random);
  } else if (path_ == FootagePath::kRotation) {
    turn_ = randomCurve(Vector3d(0.3, 0.8, 0.25) * (is_before_plane ? 0.4 : 1), 0.7, random);
  }
  // The shake has an RMS of `shake_px` per axis; a sinusoid of amplitude a has a mean square of a^2 / 2.
  constexpr double kSlowestShake = 0.35;  // radians per frame, a period of 18 frames
  shake_ = randomCurve(Vector3d::Ones(), kSlowestShake, random);
  double variance = 0;
  for (const Vector3d& amplitude : shake_.amplitudes) variance += 0.5 * amplitude.x() * amplitude.x();
  for (Vector3d& amplitude : shake_.amplitudes)
    amplitude *= scene.effects.shake_px / (focal_px * std::sqrt(variance));
}

SE3 FootageMotion::steadyPose(double time_frames) const {
  const double along = speed_ * time_frames;
  if (path_ == FootagePath::kStraight) return {SO3(), {0, 0, -along}};
  const Vector3d turn = turn_.at(along);
  const SO3 world_from_camera =
      SO3::exp({0, turn.y(), 0}) * SO3::exp({turn.x(), 0, 0}) * SO3::exp({0, 0, turn.z()});
  return SE3{world_from_camera, position_.at(along)}.inverse();
}

SE3 FootageMotion::pose(double time_frames) const {
  return SE3{SO3::exp(shake_.at(time_frames)), Vector3d::Zero()} * steadyPose(time_frames);
}

SO3 FootageMotion::smoothRotation(double time_frames, double sigma_frames) const {
  constexpr double kStepsPerSigma = 4;
  constexpr int kNumSteps = 12;  // up to three standard deviations
  const SO3 middle = pose(time_frames).rotation;
  Vector3d sum = Vector3d::Zero();
  double sum_of_weights = 0;
  for (int i = -kNumSteps; i <= kNumSteps; ++i) {
    const double t = i / kStepsPerSigma;
    const double weight = std::exp(-0.5 * t * t);
    sum += weight * (middle.inverse() * pose(time_frames + t * sigma_frames).rotation).log();
    sum_of_weights += weight;
  }
  return middle * SO3::exp(sum / sum_of_weights);
}

double FootageMotion::reach() const {
  Vector3d most = Vector3d::Zero();
  for (const Vector3d& amplitude : position_.amplitudes) most += amplitude.cwiseAbs();
  return most.norm();
}

Vector3d FootageMotion::velocity() const {
  return path_ == FootagePath::kStraight ? Vector3d(0, 0, speed_) : Vector3d::Zero();
}

}  // namespace alidade
