// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

#include "alidade/core/image.h"
#include "alidade/detect/board/detection.h"
#include "alidade/detect/board/seen_markers.h"
#include "alidade/target/board.h"

namespace alidade {

/// The positions of a board's markers, and the surroundings of its corners: four squares in alternating
/// colours.
struct MarkerPattern {
  MarkerPrint print;
  double step_m = 0;       ///< distance that the sides of the squares extend from a corner
  double clear_share = 0;  ///< blank distance from the sides, as a share of the step
  /// True if the square between columns and rows 0 and 1 is dark; the others alternate.
  bool is_first_dark = true;
  std::vector<Marker> markers = {};  ///< board frame, metres
};

/// An upright marker whose top left corner is at `low`.
[[nodiscard]] Marker squareMarker(int id, const Eigen::Vector2d& low, double side);

/// Finds a board by its markers, which give ids and first guesses. The pattern on which
/// neighbouring markers agree best is chosen. Corners are predicted from known ones around them, even next to
/// undetected markers, and fitted by CornerFitter. If the markers are mirrored, as on the back of a board
/// that is printed through or in a mirrored video, the board is found in the mirror image.
/// @param patterns  possible prints of the board: at least one, all with the same corners
[[nodiscard]] Detection findMarkerBoard(const GrayImage& image, const Board& board,
                                        const std::vector<MarkerPattern>& patterns);

}  // namespace alidade
