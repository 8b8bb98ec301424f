// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

#include "alidade/core/image.h"
#include "alidade/detect/board/detection.h"
#include "alidade/detect/board/seen_markers.h"
#include "alidade/target/board.h"

namespace alidade {

/// Where the markers of a board are, and what is around its corners: four squares in alternating colours.
struct MarkerPattern {
  MarkerPrint print;
  double step_m = 0;       ///< how far the sides of the squares reach from a corner
  double clear_share = 0;  ///< how far off them nothing is printed, as a share of the step
  /// True if the square between columns and rows 0 and 1 is dark; further ones alternate.
  bool is_first_dark = true;
  std::vector<Marker> markers = {};  ///< board frame, metres
};

/// An upright marker whose top left corner is at `low`.
[[nodiscard]] Marker squareMarker(int id, const Eigen::Vector2d& low, double side);

/// Finds a board by its markers. OpenCV's markers tell ids and first guesses; a pattern is chosen by how well
/// neighbouring markers agree on it; corners are predicted from what is known around them, beside markers
/// that were not found too, and fitted by CornerFitter.
/// @param patterns  how the board may be printed: at least one, all with the same corners
[[nodiscard]] Detection findMarkerBoard(const GrayImage& image, const Board& board,
                                        const std::vector<MarkerPattern>& patterns);

}  // namespace alidade
