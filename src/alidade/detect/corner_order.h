// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

#include "alidade/core/image.h"
#include "alidade/target/checkerboard.h"

namespace alidade {

/// A board's corners in the image, by id.
using CornerGrid = std::vector<Eigen::Vector2d>;

/// Mean grey level of the board's dark and light squares as the image shows them.
struct BoardContrast {
  double first = 0;   ///< squares of the colour of the one between corners (0, 0) and (1, 1)
  double second = 0;  ///< the others
};

[[nodiscard]] BoardContrast measureContrast(const GrayImage& image, const Checkerboard& board,
                                            const CornerGrid& grid);

/// Puts a grid that a detector returned in some row-by-row order into the one order of this project:
/// - x along the columns, y along the rows, turning clockwise in the image (z points into the board);
/// - the inner square at corner 0 is dark. Where that does not decide (both counts even or both odd), the
/// columns
///   run to the right in the image, or downwards if neither does so more.
[[nodiscard]] CornerGrid orderCorners(const GrayImage& image, const Checkerboard& board, CornerGrid grid);

/// The sides (0 left, 1 top, 2 right, 3 bottom, in board directions) on which the pattern of squares visibly
/// goes on for another whole line of corners: there the grid is only a part of a larger board.
[[nodiscard]] std::vector<int> sidesThatContinue(const GrayImage& image, const Checkerboard& board,
                                                 const CornerGrid& grid);

/// Distance from a corner to its nearest neighbour in the grid, pixels.
[[nodiscard]] double localSpacing(const Checkerboard& board, const CornerGrid& grid, int id);

}  // namespace alidade
