// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "alidade/core/diagnosis.h"
#include "alidade/record/robot_poses.h"

namespace alidade {

// Of three, two motions fit a camera on the hand as well as one on the base.
inline constexpr std::size_t kFewestPoses = 4;

/// The rows of a table for images, by name, else by number, else by order, which is noted.
/// @param images  with a board
/// @param all     all images in order, also those without a board
/// @throws Error (kInput) if too few match
[[nodiscard]] std::vector<std::optional<std::size_t>> matchedRows(const std::vector<std::string>& images,
                                                                  std::span<const std::string> all,
                                                                  const std::vector<RobotPose>& poses,
                                                                  std::vector<Diagnosis>& diagnoses);

/// A table with a row for each image between two rows of a log, if the names of both are times: decimal
/// seconds, or whole milliseconds, microseconds or nanoseconds since 1970. Poses are interpolated where rows
/// are at most 2.5 times as far apart as usual. Nothing if names agree, or if fewer than kFewestPoses images
/// are within the log.
[[nodiscard]] std::optional<RobotTable> tableAtTimes(const std::vector<std::string>& images,
                                                     const RobotTable& log,
                                                     std::vector<Diagnosis>& diagnoses);

}  // namespace alidade
