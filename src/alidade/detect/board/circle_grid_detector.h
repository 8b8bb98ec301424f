// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "alidade/core/image.h"
#include "alidade/detect/board/circle_placement.h"
#include "alidade/detect/board/detection.h"
#include "alidade/target/circle_grid.h"

namespace alidade {

/// Finds a grid of circles, dark on bright or bright on dark. Corners are the centroids of the circles'
/// images. Circles may be hidden as long as all outer lines of the grid are visible: only these identify the
/// visible part. If the grid looks the same after a rotation, the columns run to the right in the image, or
/// downwards if they are steeper than 45 degrees. Circles whose proportions differ from the board's are
/// refused.
[[nodiscard]] Detection findBoard(const GrayImage& image, const CircleGrid& board);
[[nodiscard]] Detection findBoard(const GrayImage& image, const AsymmetricCircleGrid& board);

/// A grid of circles of unknown size.
struct SeenCircles {
  CircleCounts counts;
  std::optional<double> diameter;  ///< as a share of the board's spacing; nothing if too few circles were
                                   ///< measured
};

/// The largest grid of circles in an image if all of it is visible and its rows have the spacing of a board
/// that findBoard() accepts; for a symmetric grid, the longer side comes first.
[[nodiscard]] std::optional<SeenCircles> seenCircleGrid(const GrayImage& image);

}  // namespace alidade
