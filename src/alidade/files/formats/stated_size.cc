// SPDX-License-Identifier: MIT
#include "alidade/files/formats/stated_size.h"

#include "alidade/files/formats/lens_numbers.h"

namespace alidade::detail {

StatedSide sideOf(const YamlNode& map, const std::string& key) {
  return {.key = key, .node = map.find(key)};
}

std::optional<ImageSize> sizeOfSides(const StatedSide& width, const StatedSide& height,
                                     const std::optional<ImageSize>& given, std::vector<Remark>& remarks) {
  if (width.node && height.node) return readSize(*width.node, *height.node);
  if (!width.node && !height.node) return std::nullopt;
  const StatedSide& stated = width.node ? width : height;
  const StatedSide& missing = width.node ? height : width;
  const int side = readSize(*stated.node, *stated.node).width;
  if (!given) {
    throw stated.node->error("'" + stated.key + "' without '" + missing.key + "'", "both sides of the image",
                             "add " + missing.key + ", or --image-size WIDTHxHEIGHT");
  }
  const std::string size = std::to_string(given->width) + "x" + std::to_string(given->height);
  if (side != (width.node ? given->width : given->height)) {
    throw stated.node->error(
        "'" + stated.node->text() + "' as '" + stated.key + "' but no '" + missing.key + "'",
        size + " from --image-size", "correct one of them");
  }
  remarks.push_back({"assumed", stated.node->where() + ": there is no " + missing.key + "; assumed to be " +
                                    size + " from --image-size"});
  return given;
}

}  // namespace alidade::detail
