// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "alidade/files/formats/stated_camera.h"
#include "alidade/files/yaml_node.h"

namespace alidade::detail {

/// A side of the image, in pixels, as a key of a file may state it.
struct StatedSide {
  std::string key;               ///< "image_width"
  std::optional<YamlNode> node;  ///< nothing: the key is not there
};

/// Sides as keys of `map`.
[[nodiscard]] StatedSide sideOf(const YamlNode& map, const std::string& key);

/// The size of the image in pixels; nothing where neither side is stated. One side alone is not passed over:
/// where `given` (--image-size) says the same of it, that is the size, with a remark.
/// @throws Error (kInput) that names the missing key, where `given` does not help, and for sides that are no
/// numbers of pixels
[[nodiscard]] std::optional<ImageSize> sizeOfSides(const StatedSide& width, const StatedSide& height,
                                                   const std::optional<ImageSize>& given,
                                                   std::vector<Remark>& remarks);

}  // namespace alidade::detail
