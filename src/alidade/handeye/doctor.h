// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "alidade/core/diagnosis.h"
#include "alidade/geometry/hand_eye_form.h"
#include "alidade/geometry/se3.h"
#include "alidade/record/hand_eye_record.h"
#include "alidade/record/robot_poses.h"

namespace alidade {

/// An image with its board, and the robot pose that was matched with it.
struct MatchedView {
  std::size_t pose = 0;  ///< index into RobotTable::poses, the same for all boards of an image
  std::size_t board = 0;
  SE3 camera_from_board = {};
};

/// The reading of a table with which robot and images agree best.
struct LikelyReading {
  CameraOn camera_on = CameraOn::kHand;
  /// Of each view; nothing where a shifted table has no pose.
  std::vector<std::optional<SE3>> base_from_gripper = {};
  /// The boards' places are those before the move, then those after it.
  ClosedForm form = {};
  /// The first view after the boards were moved; the number of views if they were not.
  std::size_t moved_at = 0;
  std::vector<Diagnosis> diagnoses = {};  ///< what was mended, or a failure if no reading agrees
};

/// Tries the table as it is, and mistakes that people make: readings of the numbers, inverted poses, a frame
/// of the other hand, pairs shifted by one, a board moved in the middle. A mistake is named only if the table
/// as it is contradicts the images, and far more than without it.
/// @param views      in the order of the images
/// @param camera_on  as the user states it; nothing: found
[[nodiscard]] LikelyReading likeliestReading(std::span<const MatchedView> views, std::size_t num_boards,
                                             const RobotTable& table, std::optional<CameraOn> camera_on);

}  // namespace alidade
