// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "alidade/detect/board/seen_markers.h"

namespace alidade {

/// The layout of a board's markers, as found in images.
struct MarkerLayout {
  bool is_diagonal = true;  ///< markers in every other square, as on ChArUco boards but not AprilGrids
  double spacing = 0;  ///< between columns of the lattice, in sides of a marker, accurate to a few per cent
  std::vector<int> ids = {};  ///< of the markers with a neighbour in the lattice, in order
  /// Number of squares or tags, from the change of ids between rows; 0 if ids contradict each other or there
  /// are too few neighbours. Rows count from the first one; more rows may exist that no image shows.
  int columns = 0;
  int rows = 0;
  int first_id = 0;
};

/// The layouts of the boards in images, each with four or more markers, by their lowest id; different boards
/// must have different ids.
/// @param images  the markers of one print in each image
/// @param is_upside_down  upright markers are rotated by 180 degrees on the board
[[nodiscard]] std::vector<MarkerLayout> markerLayouts(std::span<const std::vector<SeenMarker>> images,
                                                      bool is_upside_down);

}  // namespace alidade
