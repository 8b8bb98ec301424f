// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "alidade/geometry/se3.h"

namespace alidade {

/// Reads a pose from a YAML file, or from YAML text if `source` starts with '{'. The rotation is one of
///
///   quaternion_xyzw: [x, y, z, w]            any length except zero
///   quaternion_wxyz: [w, x, y, z]            the same with w first
///   rotation_vector_rad: [x, y, z]           axis times angle
///   rotation_matrix: [[...], [...], [...]]   3x3, rows; or nine numbers
///   euler_zyx_rad: [yaw, pitch, roll]        or euler_zyx_deg; R = Rz(yaw) Ry(pitch) Rx(roll)
///
/// beside translation_m: [x, y, z]; or both at once as matrix: 4x4, rows. The whole may be under a key that
/// names the frames: camera_from_world, camera_from_board and camera_from_rig are used unchanged;
/// world_from_camera, board_from_camera and rig_from_camera are inverted.
/// @returns camera_from_X
/// @throws Error (kInput) naming line and key
[[nodiscard]] SE3 readPoseSource(const std::string& source);

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
///   YAML   a list of poses (docs/files.md), or such a list under the key `poses`; each may have an `id`,
///          or an `image` that serves as one
///   table  separated by commas, semicolons or blanks, with a header that names tx, ty, tz (or x, y, z;
///          metres) and a rotation: qx, qy, qz, qw, or the rotation vector rx, ry, rz (radians). The id comes
///          from the first of the columns id, pose, name, image, frame, timestamp and time. Other columns are
///          ignored
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

/// Text of a TUM trajectory, one line per pose: timestamp tx ty tz qx qy qz qw, of world_from_camera. All
/// numbers are exact.
[[nodiscard]] std::string tumText(const std::vector<double>& times_s,
                                  const std::vector<SE3>& camera_from_world);

}  // namespace alidade
