// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/camera/any_camera.h"
#include "alidade/io/camera_file.h"
#include "alidade/io/yaml_node.h"

namespace alidade::detail {

/// Reads {width: ..., height: ...}, pixels.
[[nodiscard]] ImageSize readImageSize(const YamlNode& node);

/// Reads the keys model and parameters of a map (other keys are the caller's to check).
[[nodiscard]] AnyCamera readCamera(const YamlNode& node);

/// Reads a whole camera file of this program's own format.
[[nodiscard]] CameraFile readCameraRoot(const YamlNode& root);

}  // namespace alidade::detail
