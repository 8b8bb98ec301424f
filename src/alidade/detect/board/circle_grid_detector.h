// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/core/image.h"
#include "alidade/detect/detection.h"
#include "alidade/target/circle_grid.h"

namespace alidade {

/// Finds a grid of circles, dark on bright or bright on dark. Corners are the centroids of the circles'
/// images. Circles may be hidden as long as all outer lines of the grid are seen. Where the grid looks the
/// same turned, the columns run to the right in the image, or downwards if they are steeper than 45 degrees.
[[nodiscard]] Detection findBoard(const GrayImage& image, const CircleGrid& board);
[[nodiscard]] Detection findBoard(const GrayImage& image, const AsymmetricCircleGrid& board);

}  // namespace alidade
