// SPDX-License-Identifier: MIT
#pragma once

#include <map>
#include <string>
#include <vector>

#include "alidade/detect/board/disc_lattice.h"

namespace alidade {

/// The counts of a grid of circles.
struct CircleCounts {
  bool is_asymmetric = false;
  int columns = 0;
  int rows = 0;
  friend bool operator==(const CircleCounts&, const CircleCounts&) = default;
};
[[nodiscard]] std::string countsText(const CircleCounts& counts);

/// A placement of a lattice on a grid.
struct GridPlacement {
  CircleCounts counts;
  std::map<int, Blob> blobs;  ///< by id

  [[nodiscard]] double filled() const {
    return static_cast<double>(blobs.size()) / (counts.columns * counts.rows);
  }
};

/// All ways in which a lattice fills most of a grid, fullest first. The basis of the lattice may be any basis
/// of the grid's points; integer matrices relate them.
[[nodiscard]] std::vector<GridPlacement> gridPlacementsOf(const DiscLattice& lattice);

/// Of several placements, the one whose columns point most to the right, or downwards if steeper; null if
/// there is none.
[[nodiscard]] const GridPlacement* chosenPlacement(const std::vector<GridPlacement>& placements,
                                                   const CircleCounts& asked);

}  // namespace alidade
