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

/// A lattice laid on a grid.
struct GridPlacement {
  CircleCounts counts;
  std::map<int, Blob> blobs;  ///< by id

  [[nodiscard]] double filled() const {
    return static_cast<double>(blobs.size()) / (counts.columns * counts.rows);
  }
};

/// All ways in which a lattice fills most of a grid, the fullest first. The lattice's basis may be any of the
/// grid's, which are related by whole numbers.
[[nodiscard]] std::vector<GridPlacement> gridPlacementsOf(const DiscLattice& lattice);

/// Where several placements fit, that whose columns run most to the right, or downwards if steeper; null
/// where none fits.
[[nodiscard]] const GridPlacement* chosenPlacement(const std::vector<GridPlacement>& placements,
                                                   const CircleCounts& asked);

}  // namespace alidade
