// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "alidade/geometry/se3.h"

namespace alidade {

/// Reads a pose from a YAML file, or from YAML text when `source` starts with '{'. The rotation is one of
///
///   quaternion_xyzw: [x, y, z, w]            any length but zero
///   quaternion_wxyz: [w, x, y, z]            the same with w first
///   rotation_vector_rad: [x, y, z]           axis times angle
///   rotation_matrix: [[...], [...], [...]]   3x3, rows; or nine numbers
///   euler_zyx_rad: [yaw, pitch, roll]        or euler_zyx_deg; R = Rz(yaw) Ry(pitch) Rx(roll)
///
/// beside translation_m: [x, y, z]; or both at once as matrix: 4x4, rows. The whole may stand under a key
/// that names the frames: camera_from_world, camera_from_board, camera_from_rig as they are, and
/// world_from_camera, board_from_camera, rig_from_camera, which are inverted.
/// @returns camera_from_X
/// @throws Error (kInput) naming line and key
[[nodiscard]] SE3 readPoseSource(const std::string& source);

}  // namespace alidade
