// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "alidade/rig/joint_fit.h"
#include "alidade/rig/rig_calibration.h"

namespace alidade {

/// Finds cameras whose pose changes at some frame. Frames are in the order of their names. Two cases:
///
/// - A motion larger than the noise unlinks all of the camera's views before or after it. These agree on a
/// different pose.
/// - A smaller motion leaves the views linked. For each camera and each frame, a score test compares one pose
/// of the camera with two, with all unknowns of the rig free (Rao 1948).
///
/// @param frames      frame names, by FitPlacement::frame
/// @param covariance  of `joint`
[[nodiscard]] std::vector<CameraMotion> cameraMotions(const JointViews& views, const JointFit& joint,
                                                      const std::vector<std::string>& frames,
                                                      const RigCovariance& covariance);

}  // namespace alidade
