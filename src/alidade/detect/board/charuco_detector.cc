// SPDX-License-Identifier: MIT
#include "alidade/detect/board/charuco_detector.h"

#include "alidade/detect/board/marker_search.h"
#include "alidade/target/board.h"

namespace alidade {
namespace {

MarkerPattern patternOf(const CharucoBoard& board, bool is_bright_first) {
  const double inset = 0.5 * (board.square_m - board.marker_m);
  MarkerPattern pattern{.print = {.dictionary = board.dictionary},
                        .step_m = board.square_m,
                        .clear_share = inset / board.square_m,
                        .is_first_dark = !is_bright_first};
  int id = 0;
  for (int row = 0; row < board.rows; ++row) {
    for (int column = 0; column < board.columns; ++column) {
      if (((column + row) % 2 == 0) != is_bright_first) continue;
      const Eigen::Vector2d low = board.square_m * Eigen::Vector2d(column - 1, row - 1);
      pattern.markers.push_back(squareMarker(id++, low + Eigen::Vector2d(inset, inset), board.marker_m));
    }
  }
  return pattern;
}

}  // namespace

Detection findBoard(const GrayImage& image, const CharucoBoard& board) {
  return findMarkerBoard(image, board, {patternOf(board, false), patternOf(board, true)});
}

}  // namespace alidade
