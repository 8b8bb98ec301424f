// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/camera/any_camera.h"
#include "alidade/files/text/yaml_node.h"

// Parts of Alidade's camera files that scene files share. They are read strictly: unknown, missing, duplicate
// and misspelt keys, wrong types, numbers that are not finite and unknown models are errors that name line,
// key, found and expected.
namespace alidade::detail {

/// Reads {width: ..., height: ...}, pixels.
[[nodiscard]] ImageSize readImageSize(const YamlNode& node);

/// Reads the keys model and parameters of a map (other keys are the caller's to check).
[[nodiscard]] AnyCamera readCamera(const YamlNode& node);

}  // namespace alidade::detail
