// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "alidade/files/text/pose_forms.h"
#include "alidade/geometry/se3.h"

namespace alidade {

/// Reads a pose from a YAML file, or from YAML text if `source` starts with '{'. The rotation is one of the
/// forms in pose_forms.h, such as
///
///   quaternion_xyzw: [x, y, z, w]            any length except zero
///   rotation_vector_rad: [x, y, z]           axis times angle; or rotation_vector_deg
///   rotation_matrix: [[...], [...], [...]]   3x3, rows; or nine numbers
///   euler_zyx_rad: [yaw, pitch, roll]        or euler_zyx_deg; R = Rz(yaw) Ry(pitch) Rx(roll)
///
/// beside translation_m: [x, y, z]; or both at once as matrix: 4x4, rows. The whole may be under a key that
/// names the frames: camera_from_world, camera_from_board, camera_from_rig and camera_from_object are used
/// unchanged; world_from_camera and so on are inverted. camera_to_world is world_from_camera. Also read are
/// OpenCV's rvec and tvec (camera_from_object), ROS's position and orientation, R and t, and nerfstudio's
/// transform_matrix (world_from_camera with OpenGL's axes, which are turned).
/// @returns camera_from_X
/// @throws Error (kInput) naming line and key
[[nodiscard]] SE3 readPoseSource(const std::string& source);

/// The words for the direction of poses that do not state it; the last two mean the same as the first two.
inline const std::vector<std::string> kPoseDirections = {"camera_from_world", "world_from_camera",
                                                         "world_to_camera", "camera_to_world"};

struct PoseList {
  std::vector<NamedPose> poses;      ///< in the file's order; at least one
  std::vector<std::string> remarks;  ///< what was assumed, or changed
};

/// Reads many poses:
///
///   YAML   a list of poses (docs/files.md), or such a list under the key `poses`; each may have an `id`,
///          or an `image` that serves as one; or the frames of a transforms.json of nerfstudio
///   table  separated by commas, semicolons or blanks, with a header that names tx, ty, tz (or x, y, z;
///          metres) and a rotation: qx, qy, qz, qw, or the rotation vector rx, ry, rz (radians). The id comes
///          from the first of the columns id, pose, name, image, frame, timestamp and time. Other columns are
///          ignored
///   rows   without a header: of TUM (timestamp tx ty tz qx qy qz qw, world_from_camera), of KITTI (3x4,
///          world_from_camera), of tf of ROS (tx ty tz qx qy qz qw), of 4x4 matrices, or of COLMAP's
///          images.txt (camera_from_world; its lines of points are skipped)
///
/// `frames` is the direction of poses that do not state it: camera_from_world or world_from_camera, or
/// world_to_camera or camera_to_world, which mean the same. YAML poses under such a key state their
/// direction; others are camera_from_x by default. Tables with a header need `frames`.
/// @throws Error (kInput) naming file, line, and key or column
[[nodiscard]] PoseList readPoseList(const std::string& path, const std::string& frames = "");

/// The same from text; messages use `name` as the file name.
[[nodiscard]] PoseList parsePoseList(const std::string& text, const std::string& name,
                                     const std::string& frames = "");

/// Reads poses that need not be those of a camera, from a file, from standard input ("-"), or from the source
/// itself if it is YAML in braces or numbers. With a form, the text is only numbers, in any number of lines.
[[nodiscard]] PoseList readAnyPoses(const std::string& source, const std::string& frames,
                                    const std::optional<PoseForm>& form);

/// Rows of poses that stand in a table without a header.
struct PoseRows {
  std::string name;                  ///< for poseText(); empty if it does not write them
  std::vector<std::string> columns;  ///< empty names: the numbers of the form
  std::string form;
  std::string frames;
  std::string title;
};
/// Those of CSV, TUM, KITTI and others.
[[nodiscard]] const std::vector<PoseRows>& poseRows();

/// Text of the stated poses, one line per pose: rows, or YAML in a form of pose_forms.h. Poses camera_from_X
/// are inverted for rows that are world_from_camera.
/// @param remarks  gets what was changed, and gimbal lock
/// @throws Error (kUsage) if the rows cannot hold the poses
[[nodiscard]] std::string poseText(const std::vector<NamedPose>& poses, const std::string& form,
                                   std::vector<std::string>& remarks);

/// Text of a TUM trajectory, one line per pose: timestamp tx ty tz qx qy qz qw, of world_from_camera. All
/// numbers are exact.
[[nodiscard]] std::string tumText(const std::vector<double>& times_s,
                                  const std::vector<SE3>& camera_from_world);

}  // namespace alidade
