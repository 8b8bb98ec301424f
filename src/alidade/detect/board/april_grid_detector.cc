// SPDX-License-Identifier: MIT
#include "alidade/detect/board/april_grid_detector.h"

#include <algorithm>

#include "alidade/detect/board/marker_search.h"
#include "alidade/target/board.h"

namespace alidade {
namespace {

MarkerPattern patternOf(const AprilGrid& board, int border) {
  const int num_cells = findMarkerDictionary(AprilGrid::kDictionary)->num_bits + 2 * border;
  MarkerPattern pattern{
      .print = {.dictionary = std::string(AprilGrid::kDictionary), .border = border, .is_apart = true},
      .step_m = board.gap * board.tag_m,
      .clear_share = std::min(1.0, border / (num_cells * board.gap))};
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
