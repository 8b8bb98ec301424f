// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "alidade/geometry/se3.h"

namespace alidade {

struct TimedPose {
  double time = 0;  ///< in seconds, or the number of the frame
  SE3 camera_from_world;
};

/// Poses that have a world and a scale in common.
struct TrajectoryPiece {
  std::vector<std::string> comments;  ///< lines before its first pose
  std::vector<TimedPose> poses;
};

/// A trajectory in the format of the TUM benchmark (Sturm et al. 2012), which readPoseList() reads: a pose a
/// line, timestamp tx ty tz qx qy qz qw, world_from_camera; comments begin with #.
/// @param comments  lines at the top
[[nodiscard]] std::string trajectoryText(std::span<const std::string> comments,
                                         std::span<const TrajectoryPiece> pieces);

/// Points in the worlds of the pieces of a trajectory as a PLY file in text form (Turk 1994) with the
/// properties x, y, z and piece, which counts from 1.
/// @param comments  lines at the top
/// @param pieces    the points of each piece
[[nodiscard]] std::string pointCloudText(std::span<const std::string> comments,
                                         std::span<const std::vector<Eigen::Vector3d>> pieces);

}  // namespace alidade
