// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "alidade/geometry/se3.h"

namespace alidade {

/// The direction of poses in a file that does not state it.
enum class PoseDirection { kCameraFromWorld, kWorldFromCamera };

struct NamedPose {
  std::string id;     ///< from the file; otherwise the index of the pose, from 0
  SE3 camera_from_x;  ///< transforms points to the camera frame
};

struct PoseList {
  std::vector<NamedPose> poses;  ///< in the file's order; at least one
  bool is_assumed_tum = false;   ///< eight unnamed columns were assumed to be a TUM trajectory
};

/// Reads many poses:
///
///   YAML   a list of poses (docs/files.md), or such a list under the key `poses`; each may have an `id`
///   table  separated by commas or blanks, with a header that names tx, ty, tz (or x, y, z; metres) and a
///          rotation: qx, qy, qz, qw, or the rotation vector rx, ry, rz (radians). The id comes from the
///          first of the columns id, pose, name, image, frame, timestamp and time. Other columns are ignored
///   TUM    a table without a header: timestamp tx ty tz qx qy qz qw, world_from_camera
///
/// `direction` is the direction of the poses. YAML poses under a key such as camera_from_world or
/// world_from_camera state their direction; others are camera_from_x by default. Tables with a header need
/// `direction`.
/// @throws Error (kInput) naming file, line, and key or column
[[nodiscard]] PoseList readPoseList(const std::string& path, std::optional<PoseDirection> direction);

/// The same from text; messages use `name` as the file name.
[[nodiscard]] PoseList parsePoseList(const std::string& text, const std::string& name,
                                     std::optional<PoseDirection> direction);

}  // namespace alidade
