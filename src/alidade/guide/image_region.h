// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "alidade/core/image.h"

namespace alidade {

/// A ninth of an image: thirds of its width and of its height.
struct ImageRegion {
  int column = 0;  ///< 0 left, 1 middle, 2 right
  int row = 0;     ///< 0 upper, 1 middle, 2 lower

  friend bool operator==(const ImageRegion&, const ImageRegion&) = default;
};

/// The region that holds a pixel; pixels beyond the image belong to the nearest region.
[[nodiscard]] ImageRegion regionAt(const Eigen::Vector2d& pixel, ImageSize size);

/// "upper left corner", "left border", "centre", ...
[[nodiscard]] std::string regionName(const ImageRegion& region);

/// "in the upper left corner", "at the left border", "in the centre", ...
[[nodiscard]] std::string placeName(const ImageRegion& region);

/// Names as a list for people: "the upper left corner, the left border and the centre".
[[nodiscard]] std::string regionNames(const std::vector<ImageRegion>& regions);

}  // namespace alidade
