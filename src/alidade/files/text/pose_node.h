// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "alidade/files/text/yaml_node.h"
#include "alidade/geometry/se3.h"

namespace alidade::detail {

/// Reads a pose in any of the representations that pose_list.h lists. `beside`: keys that may accompany them.
[[nodiscard]] SE3 readPose(const YamlNode& node, const std::vector<std::string>& beside = {});

/// Reads a pose under a key that names the frames, as in pose_list.h: camera_from_X. Nothing if there is no
/// such key.
[[nodiscard]] std::optional<SE3> readFramedPose(const YamlNode& node,
                                                const std::vector<std::string>& beside = {});

/// Writes {quaternion_xyzw: [...], translation_m: [...]} with w >= 0.
void writePose(YAML::Emitter& out, const SE3& pose);

}  // namespace alidade::detail
