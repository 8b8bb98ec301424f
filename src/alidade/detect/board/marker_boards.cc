// SPDX-License-Identifier: MIT
#include <algorithm>

#include "alidade/detect/board/find_board.h"
#include "alidade/detect/board/marker_search.h"

namespace alidade {
namespace {

MarkerPattern patternOf(const CharucoBoard& board, bool is_bright_first) {
  const double inset = 0.5 * (board.square_m - board.marker_m);
  MarkerPattern pattern{.print = {.dictionary = board.dictionary},
                        .step_m = board.square_m,
                        .clear_share = inset / board.square_m,
                        .is_first_dark = !is_bright_first};
  int id = board.first_id;
  for (int row = 0; row < board.rows; ++row) {
    for (int column = 0; column < board.columns; ++column) {
      if (((column + row) % 2 == 0) != is_bright_first) continue;
      const Eigen::Vector2d low = board.square_m * Eigen::Vector2d(column - 1, row - 1);
      pattern.markers.push_back(squareMarker(id++, low + Eigen::Vector2d(inset, inset), board.marker_m));
    }
  }
  return pattern;
}

MarkerPattern patternOf(const AprilGrid& board, int border) {
  MarkerPattern pattern{
      .print = {.dictionary = std::string(AprilGrid::kDictionary), .border = border, .is_apart = true},
      .step_m = board.gap * board.tag_m};
  pattern.clear_share = std::min(1.0, border / (pattern.print.numCells() * board.gap));
  for (int row = 0; row < board.rows; ++row) {
    for (int column = 0; column < board.columns; ++column) {
      auto marker =
          squareMarker(board.tagId(column, row), {board.tagPlace(column), board.tagPlace(row)}, board.tag_m);
      if (AprilGrid::kIsUpsideDown)
        std::rotate(marker.corners.begin(), marker.corners.begin() + 2, marker.corners.end());
      pattern.markers.push_back(marker);
    }
  }
  return pattern;
}

}  // namespace

Detection findBoard(const GrayImage& image, const CharucoBoard& board) {
  return findMarkerBoard(image, board, {patternOf(board, false), patternOf(board, true)});
}

Detection findBoard(const GrayImage& image, const AprilGrid& board) {
  std::vector<MarkerPattern> patterns;
  for (const int border : AprilGrid::kBorders) patterns.push_back(patternOf(board, border));
  const Detection detection = findMarkerBoard(image, board, patterns);
  if (detection.reason != DetectionReason::kNoBoard && detection.reason != DetectionReason::kUnplaced)
    return detection;
  // Bright tags touch the small squares at their corners. On a negative, the dark squares hide the outlines
  // of the tags.
  const Detection inverted = findMarkerBoard(negativeOf(image), board, patterns);
  return inverted.hasCorners() ? inverted : detection;
}

}  // namespace alidade
