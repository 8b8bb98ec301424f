// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "alidade/geometry/se3.h"

namespace alidade {

/// Which way the poses of a file go, where the file does not say.
enum class PoseDirection { kCameraFromWorld, kWorldFromCamera };

struct NamedPose {
  std::string id;     ///< as in the file; without one there, the pose's index from 0
  SE3 camera_from_x;  ///< from the frame of the points
};

struct PoseList {
  std::vector<NamedPose> poses;  ///< in the file's order; at least one
  bool is_assumed_tum = false;   ///< eight columns that nothing names were taken for a TUM trajectory
};

/// Reads many poses:
///
///   YAML   a list of poses as readPoseSource() takes them, or such a list under the key `poses`; each may
///   have
///          an `id` of its own
///   table  (see TableLines) with a header that names tx, ty, tz (or x, y, z; metres), and qx, qy, qz, qw or
///   the
///          rotation vector rx, ry, rz (radians), and perhaps id, pose, name, image, frame, timestamp or
///          time, of which the first in this order is the id; other columns are ignored
///   TUM    a table without a header: timestamp tx ty tz qx qy qz qw, world_from_camera
///
/// `direction` says which way the poses go. YAML poses that stand under camera_from_world, world_from_camera
/// and so on say so themselves, others are camera_from_x unless it is given; a table with a header needs it.
/// @throws Error (kInput) naming file, line, and key or column
[[nodiscard]] PoseList readPoseList(const std::string& path, std::optional<PoseDirection> direction);

/// The same from text; `name` stands for the file in messages.
[[nodiscard]] PoseList parsePoseList(const std::string& text, const std::string& name,
                                     std::optional<PoseDirection> direction);

}  // namespace alidade
