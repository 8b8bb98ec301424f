// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "alidade/files/text/pose_forms.h"
#include "alidade/files/text/yaml_node.h"
#include "alidade/geometry/se3.h"

namespace alidade::detail {

/// "camera_from_world" for this key and the same in other words, such as world_to_camera; empty for keys that
/// are no frames, or without `is_any` not those of a camera.
[[nodiscard]] std::string poseFrames(const std::string& key, bool is_any);

/// Reads a pose in any of the representations that pose_list.h lists, alone or under a key that names the
/// frames, with neither its id nor camera_from_x. `beside`: keys that may accompany them. `is_any`: it may
/// also be a rotation alone, and its frames may be others than those of a camera.
[[nodiscard]] NamedPose readStatedPose(const YamlNode& node, const std::vector<std::string>& beside,
                                       bool is_any);

/// Reads a pose whose frames are known from its place in the file.
[[nodiscard]] SE3 readPose(const YamlNode& node, const std::vector<std::string>& beside = {});

/// Writes {quaternion_xyzw: [...], translation_m: [...]} with w >= 0.
void writePose(YAML::Emitter& out, const SE3& pose);

}  // namespace alidade::detail
