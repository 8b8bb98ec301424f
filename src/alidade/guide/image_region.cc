// SPDX-License-Identifier: MIT
#include "alidade/guide/image_region.h"

#include <algorithm>
#include <cmath>

namespace alidade {

ImageRegion regionAt(const Eigen::Vector2d& pixel, ImageSize size) {
  const auto third = [](double at, int length) {
    return static_cast<int>(std::clamp(std::floor(3 * (at + 0.5) / length), 0.0, 2.0));
  };
  return {.column = third(pixel.x(), size.width), .row = third(pixel.y(), size.height)};
}

std::string regionName(const ImageRegion& region) {
  const std::string row = region.row == 0 ? "upper" : region.row == 2 ? "lower" : "";
  const std::string column = region.column == 0 ? "left" : region.column == 2 ? "right" : "";
  if (row.empty() && column.empty()) return "centre";
  if (row.empty() || column.empty()) return row + column + " border";
  return row + " " + column + " corner";
}

std::string placeName(const ImageRegion& region) {
  const bool is_border = (region.row == 1) != (region.column == 1);
  return (is_border ? "at the " : "in the ") + regionName(region);
}

std::string regionNames(const std::vector<ImageRegion>& regions) {
  std::string text;
  for (std::size_t i = 0; i < regions.size(); ++i) {
    if (i > 0) text += i + 1 == regions.size() ? " and " : ", ";
    text += "the " + regionName(regions[i]);
  }
  return text;
}

}  // namespace alidade
