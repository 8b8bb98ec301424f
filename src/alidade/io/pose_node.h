// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/geometry/se3.h"
#include "alidade/io/yaml_node.h"

namespace alidade::detail {

/// Reads a pose written in any of the representations that pose_file.h lists.
[[nodiscard]] SE3 readPose(const YamlNode& node);

/// Writes {quaternion_xyzw: [...], translation_m: [...]} with w >= 0.
void writePose(YAML::Emitter& out, const SE3& pose);

}  // namespace alidade::detail
