// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "alidade/core/image.h"
#include "alidade/detect/board/detection.h"
#include "alidade/detect/board/disc_lattice.h"

namespace alidade {

/// Finds a whole or partly visible checkerboard in a grey image and refines its corners (CornerFitter). The
/// search uses reduced resolutions, the refinement the full one. For an unambiguous board,
/// the ids refer to the same physical corners in every view: seen in the image, the rows (y) run a quarter
/// turn clockwise from the columns (x), and the inner square at corner 0 is dark. For an ambiguous board, the
/// columns run to the right in the image, or downwards if they are steeper than 45 degrees.
[[nodiscard]] Detection findBoard(const GrayImage& image, const Checkerboard& board);

/// Finds a ChArUco board of either layout, dark on white or white on dark. Ids of corners are those of the
/// markers around them.
[[nodiscard]] Detection findBoard(const GrayImage& image, const CharucoBoard& board);

/// Finds an AprilGrid whose tags have any of AprilGrid::kBorders, black on white or white on black. Tags of
/// other ids belong to other boards.
[[nodiscard]] Detection findBoard(const GrayImage& image, const AprilGrid& board);

/// Finds a grid of circles, dark on bright or bright on dark. Corners are the centroids of the circles'
/// images. Circles may be hidden as long as all outer lines of the grid are seen: nothing else tells which
/// part is seen. Where the grid looks the same turned, the columns run to the right in the image, or
/// downwards if they are steeper than 45 degrees. Circles of other proportions than the board's are refused.
[[nodiscard]] Detection findBoard(const GrayImage& image, const CircleGrid& board);
[[nodiscard]] Detection findBoard(const GrayImage& image, const AsymmetricCircleGrid& board);

/// A grid of circles of unknown size.
struct SeenCircles {
  CircleCounts counts;
  std::optional<double> diameter;  ///< as a share of the board's spacing; nothing if too few circles tell
};

/// The largest grid of circles in an image, if it is seen whole and its rows are as far apart as on a
/// board that findBoard() takes; of a symmetric one, the longer side first.
[[nodiscard]] std::optional<SeenCircles> seenCircleGrid(const GrayImage& image);

}  // namespace alidade
