// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "alidade/camera/any_camera.h"
#include "alidade/files/camera_file.h"
#include "alidade/files/text/yaml_node.h"
#include "alidade/geometry/se3.h"
#include "alidade/record/rig_record.h"

// Cameras and poses as YAML nodes.
namespace alidade::detail {

/// Reads {width: ..., height: ...}, pixels.
[[nodiscard]] ImageSize readImageSize(const YamlNode& node);

/// Reads the keys model and parameters of a map (other keys are the caller's to check).
[[nodiscard]] AnyCamera readCamera(const YamlNode& node);

/// Reads a whole camera file of this program's own format.
[[nodiscard]] CameraRecord readCameraRoot(const YamlNode& root);

[[nodiscard]] Verdict readVerdict(const YamlNode& node);

/// Reads the lower triangle of a symmetric matrix, a row an item, or all in one list as the first edition
/// wrote it.
[[nodiscard]] std::vector<double> readTriangle(const YamlNode& node, std::size_t num_rows);

/// The user's own keys of a file's root, with their values, as lines of YAML; comments are lost.
[[nodiscard]] std::string userKeys(const YAML::Node& root);

/// Checks the version and the keys of a rig file.
void checkRigRoot(const YamlNode& root);
/// Reads an item of a rig file's `cameras`.
[[nodiscard]] RigCameraRecord readRigCamera(const YamlNode& entry);

/// Reads a pose written in any of the representations that pose_list.h lists. `beside`: keys that may stand
/// beside them.
[[nodiscard]] SE3 readPose(const YamlNode& node, const std::vector<std::string>& beside = {});

/// The same, or under a key that names the frames, as pose_list.h says. @returns camera_from_X
struct FramedPose {
  SE3 camera_from_x;
  bool is_framed = false;  ///< it stood under such a key
};
[[nodiscard]] FramedPose readFramedPose(const YamlNode& node, const std::vector<std::string>& beside = {});

/// Writes {quaternion_xyzw: [...], translation_m: [...]} with w >= 0.
void writePose(YAML::Emitter& out, const SE3& pose);

}  // namespace alidade::detail
