// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "alidade/files/text/yaml_node.h"
#include "alidade/geometry/se3.h"

namespace alidade::detail {

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
