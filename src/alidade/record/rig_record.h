// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "alidade/camera/any_rig.h"
#include "alidade/core/diagnosis.h"
#include "alidade/geometry/se3.h"
#include "alidade/record/camera_record.h"

namespace alidade {

/// A camera of a rig file.
struct RigCameraRecord {
  CameraRecord camera;  ///< its name is unique in the rig
  SE3 camera_from_rig = {};
  /// Standard deviations of the tangent of camera_from_rig; zero for the camera at the rig's origin.
  Eigen::Vector3d translation_std_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d rotation_std_rad = Eigen::Vector3d::Zero();
  /// Time at which it takes an image minus that of the first camera's image with the same number, s; nothing
  /// if unknown.
  std::optional<double> time_offset_s = {};
};

/// The content of a rig file: several cameras and their poses.
struct RigRecord {
  std::vector<RigCameraRecord> cameras;
  Verdict verdict = Verdict::kTrustworthy;
  double rms_px = 0;
  int num_frames = 0;  ///< with a board that two or more cameras saw
  std::vector<std::string> findings;
  std::string created_by;
  std::string user_keys = {};  ///< the user's keys (x_...) and values, as lines of YAML
  /// Joint covariance, lower triangle row by row: the parameters of each camera, then the tangent of
  /// camera_from_rig of each camera but the first; empty = unknown.
  std::vector<double> covariance = {};

  /// True if it is known how the poses were estimated. Otherwise verdict, rms_px and findings mean nothing.
  [[nodiscard]] bool isCalibrated() const { return num_frames > 0 || !findings.empty(); }
};

/// The cameras of the record at their poses. @throws Error as AnyRig's constructor
[[nodiscard]] AnyRig rigOf(const RigRecord& record);

/// Sorts the cameras of `rig` into the order of those of `other` with the same names. The joint covariance is
/// dropped if the order changes. @returns false, with nothing changed, if the names differ
bool orderCamerasAs(const RigRecord& other, RigRecord& rig);

}  // namespace alidade
