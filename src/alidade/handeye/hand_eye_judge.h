// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <vector>

#include "alidade/geometry/hand_eye_form.h"
#include "alidade/handeye/hand_eye_calibration.h"
#include "alidade/handeye/joint_fit.h"

namespace alidade {

/// Adds a failure if the robot turned about one axis, or not at all.
void judgeMotion(const ClosedForm& form, HandEyeCalibration& result);

/// Takes the solved fit into the result, states its accuracy, and adds what is wrong with it.
/// @param left_out  frames that contradict the others
void judgeHandEye(const RobotFit& fit, const std::vector<std::size_t>& left_out,
                  const HandEyeOptions& options, HandEyeCalibration& result);

}  // namespace alidade
