// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <optional>

#include <Eigen/Core>

#include "alidade/core/image.h"

namespace alidade {

/// Grey level between pixels, from the four nearest. The place must be inside the image.
[[nodiscard]] inline double greyInside(const GrayImage& image, const Eigen::Vector2d& pixel) {
  const int x = std::min(static_cast<int>(pixel.x()), std::max(0, image.size.width - 2));
  const int y = std::min(static_cast<int>(pixel.y()), std::max(0, image.size.height - 2));
  const int next_x = std::min(x + 1, image.size.width - 1);
  const int next_y = std::min(y + 1, image.size.height - 1);
  const double fx = pixel.x() - x;
  const double fy = pixel.y() - y;
  return (1 - fy) * ((1 - fx) * image.at(x, y) + fx * image.at(next_x, y)) +
         fy * ((1 - fx) * image.at(x, next_y) + fx * image.at(next_x, next_y));
}

/// The same; nothing outside the image.
[[nodiscard]] inline std::optional<double> greyAt(const GrayImage& image, const Eigen::Vector2d& pixel) {
  if (!(pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() <= image.size.width - 1 &&
        pixel.y() <= image.size.height - 1))
    return std::nullopt;
  return greyInside(image, pixel);
}

}  // namespace alidade
