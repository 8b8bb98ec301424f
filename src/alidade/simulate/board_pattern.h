// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "alidade/target/checkerboard.h"

namespace alidade {

/// What is seen at a place of the board's plane.
enum class BoardTone {
  kDark,        ///< a dark square
  kBright,      ///< a bright square or the paper's margin, one square wide, around the squares
  kBackground,  ///< beyond the paper
};

/// Around columns x rows inner corners lie (columns + 1) x (rows + 1) squares. The one between the corners
/// (0, 0) and (1, 1) is dark, and so is its diagonal neighbour beyond corner 0: that is what tells corner 0.
/// `point_board`: x and y in the board frame, metres; anything not finite is background.
[[nodiscard]] BoardTone boardTone(const Checkerboard& board, const Eigen::Vector2d& point_board);

/// Distance in metres from `point_board` to the nearest line across which the tone may change: the tone is
/// the same everywhere nearer than that. All sides of squares count, also those between a bright square and
/// the margin. NaN for NaN.
[[nodiscard]] double edgeDistance(const Checkerboard& board, const Eigen::Vector2d& point_board);

}  // namespace alidade
