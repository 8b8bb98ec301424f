// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include <Eigen/Core>

#include "alidade/geometry/se3.h"
#include "alidade/record/footage_scene.h"

namespace alidade {

/// A smooth curve in three coordinates: sums of three sinusoids whose frequencies have no common period.
struct SmoothCurve {
  std::array<Eigen::Vector3d, 3> amplitudes = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(),
                                               Eigen::Vector3d::Zero()};
  std::array<Eigen::Vector3d, 3> frequencies = amplitudes;  ///< radians per unit of the parameter
  std::array<Eigen::Vector3d, 3> phases = amplitudes;       ///< radians

  [[nodiscard]] Eigen::Vector3d at(double parameter) const;
};

/// Motion of a camera over time, which is counted in frames. The world frame is that of the camera in the
/// middle of its path, or at time 0 for straight paths.
class FootageMotion {
 public:
  /// `focal_px`: pixels per radian at the image centre.
  FootageMotion(const FootageScene& scene, double focal_px);

  /// Metres per frame for straight paths; for others, the change of the curve parameter per frame.
  [[nodiscard]] double speed() const { return speed_; }
  void setSpeed(double speed) { speed_ = speed; }

  /// camera_from_world without hand shake.
  [[nodiscard]] SE3 steadyPose(double time_frames) const;
  /// camera_from_world.
  [[nodiscard]] SE3 pose(double time_frames) const;
  /// The rotation of pose() smoothed by a Gaussian over time of this standard deviation, in frames.
  [[nodiscard]] SO3 smoothRotation(double time_frames, double sigma_frames) const;

  /// Largest distance of any position from the origin, metres; 0 for straight paths, which have no limit.
  [[nodiscard]] double reach() const;
  /// Constant part of the translation per frame, metres.
  [[nodiscard]] Eigen::Vector3d velocity() const;

 private:
  FootagePath path_;
  double speed_ = 0;
  SmoothCurve position_;  // metres
  SmoothCurve turn_;      // about x (pitch), y (yaw) and z (roll), radians
  SmoothCurve shake_;     // rotation vector, radians; over time in frames
};

}  // namespace alidade
