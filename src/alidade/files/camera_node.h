// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string_view>

#include "alidade/camera/any_camera.h"
#include "alidade/files/camera_file.h"
#include "alidade/files/yaml_node.h"

namespace alidade::detail {

/// Reads {width: ..., height: ...}, pixels.
[[nodiscard]] ImageSize readImageSize(const YamlNode& node);

/// Reads the keys model and parameters of a map (other keys are the caller's to check).
[[nodiscard]] AnyCamera readCamera(const YamlNode& node);

/// Checks that a map has no other keys than a model's parameters, which are `names`. @throws Error (kInput)
/// that names the other model, if the keys are all those of one
void allowParameters(const YamlNode& map, std::span<const std::string_view> names);

/// Reads a whole camera file of this program's own format.
/// @param text  from which the root was parsed
[[nodiscard]] CameraRecord readCameraRoot(const YamlNode& root, const std::string& text);

}  // namespace alidade::detail
