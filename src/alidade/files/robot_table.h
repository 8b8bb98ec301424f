// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "alidade/record/robot_poses.h"

namespace alidade {

struct RobotTableOptions {
  /// What the numbers mean where the header does not say it: kuka, abb, ur, fanuc, staubli, franka, matrix,
  /// matrix_3x4, or a form of a rotation alone (pose_forms.h), which follows x y z in metres. Empty: 16 or 12
  /// numbers are matrices, 7 have a quaternion x, y, z, w, and 6 a rotation vector in radians.
  std::string form = {};
};

/// Reads the poses base_from_gripper that a robot stated for images:
///
///   table  with a header: a name (image, filename, name, id, time or timestamp), x, y, z, also as tx, px,
///   pos_x or
///          position_x (m or mm), and
///          one of qx, qy, qz, qw; rx, ry, rz (a rotation vector, in rad or deg); roll, pitch, yaw; ABB's
///          q1, q2, q3, q4; KUKA's a, b, c; FANUC's w, p, r. Columns in any order
///   rows   without a header, with or without a name in front (TUM: a time)
///
/// Fields are separated by commas, semicolons or blanks; '#' begins a comment, which may hold the header.
/// `others` are at most 12 other readings of the same numbers, as common mistakes make them necessary.
/// @throws Error (kInput) naming file and line; Error (kUsage) for an unknown form
[[nodiscard]] RobotTable readRobotTable(const std::string& path, const RobotTableOptions& options = {});

/// The same from text; messages use `name` as the file name.
[[nodiscard]] RobotTable parseRobotTable(const std::string& text, const std::string& name,
                                         const RobotTableOptions& options = {});

/// Text of a table with the header image,x_m,y_m,z_m,qx,qy,qz,qw; with one of the mistakes of writing numbers
/// in another form than the header states, or none.
[[nodiscard]] std::string robotTableText(const std::vector<RobotPose>& poses,
                                         std::optional<RobotMistake> mistake = {});

}  // namespace alidade
