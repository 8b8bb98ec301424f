// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "alidade/core/image.h"

namespace alidade {

/// Half the size (rounded down): each pixel is the mean of four. A pixel c of the half image lies at
/// 2 (c + 0.5) - 0.5 of the whole one. Empty where a side is shorter than 2.
[[nodiscard]] GrayImage halved(const GrayImage& image);

/// Where a pixel of an image that was halved `times` times lies in the whole one.
[[nodiscard]] inline Eigen::Vector2d fromHalved(const Eigen::Vector2d& pixel, int times) {
  const double scale = 1 << times;
  return scale * (pixel.array() + 0.5).matrix() - Eigen::Vector2d(0.5, 0.5);
}

}  // namespace alidade
