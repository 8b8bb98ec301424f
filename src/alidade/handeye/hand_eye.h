// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <vector>

#include "alidade/handeye/hand_eye_calibration.h"
#include "alidade/record/hand_eye_record.h"
#include "alidade/record/robot_poses.h"
#include "alidade/target/board.h"
#include "alidade/target/view.h"

namespace alidade {

/// Calibrates where a camera is on a robot's hand or beside the robot, in one fit of the camera, the
/// transform, the boards' places and the robot's own errors, whose size is estimated with the rest. Robot
/// poses are matched with views by name, by number, by time, or by their order.
/// @throws Error (kInput) as calibrate(), and for poses that match no images or fewer than four of them, or
/// whose motion cannot determine the transform; Cancelled
[[nodiscard]] HandEyeCalibration calibrateHandEye(std::span<const Board> boards, std::vector<View> views,
                                                  const RobotTable& robot,
                                                  const HandEyeOptions& options = {});

/// Keeps the lens of a camera in options of a calibration.
/// @throws Error (kInput) for a camera of corrected images
void keepLens(const CameraRecord& record, CalibratorOptions& options);

/// All that a hand-eye file holds of it. Without a solution, numbers are NaN, and it cannot be written.
[[nodiscard]] HandEyeRecord recordOf(const HandEyeCalibration& calibration, std::string created_by);

}  // namespace alidade
