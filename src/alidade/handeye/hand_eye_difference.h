// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/geometry/se3.h"
#include "alidade/record/hand_eye_record.h"

namespace alidade {

/// How one hand-eye transform differs from another of the same camera and robot.
struct HandEyeDifference {
  double translation_m = 0;
  double rotation_rad = 0;
  double point_m = 0;      ///< of a point on the camera's axis, in the mount's frame
  double point_std_m = 0;  ///< standard deviation of that, by both covariances
  /// The normal variable that is exceeded as often as such a difference, if both were right; 0 if a
  /// covariance is unknown.
  double sigmas = 0;

  [[nodiscard]] bool isSignificant() const;
};

/// @param distance_m  of the point from the camera
/// @throws Error (kInput) if one camera is on the hand and the other on the base
[[nodiscard]] HandEyeDifference differenceOf(const HandEyeRecord& a, const HandEyeRecord& b,
                                             double distance_m);

}  // namespace alidade
