// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "alidade/detect/board/seen_markers.h"

namespace alidade {

/// What images show of a board's markers.
struct MarkerLayout {
  bool is_diagonal = true;  ///< in every other square, as on ChArUco boards, and not as on AprilGrids
  double spacing = 0;  ///< between the lattice's columns, as a multiple of a marker's side, to a few per cent
  std::vector<int> ids = {};  ///< of the markers that have a neighbour in the lattice, in order
  /// Of squares or tags, by how the ids go on from row to row; 0 where the ids contradict each other or too
  /// few neighbours are seen. Rows count from the first one, and further ones may follow that nothing shows.
  int columns = 0;
  int rows = 0;
  int first_id = 0;  ///< of an upright lattice; diagonal ones start at 0
};

/// The layouts of the boards that images show, each with four markers or more, by their lowest id; ids of
/// other boards must differ. `images` are the markers of one print that each image shows.
/// @param is_upside_down  whether upright markers are turned by 180 degrees on the board
[[nodiscard]] std::vector<MarkerLayout> markerLayouts(std::span<const std::vector<SeenMarker>> images,
                                                      bool is_upside_down);

}  // namespace alidade
