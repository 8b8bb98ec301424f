// SPDX-License-Identifier: MIT
#pragma once

#include <map>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "alidade/core/image.h"

namespace alidade {

/// A spot that resembles an ellipse.
struct Blob {
  Eigen::Vector2d pixel;  ///< its centroid
  Eigen::Matrix2d shape;  ///< see DiscGuess
  double area_px = 0;
};

/// A blob at a place of a lattice, counted along its two directions from an arbitrary origin. The second
/// direction is clockwise from the first in the image.
struct LatticeNode {
  int i = 0;
  int j = 0;
  Blob blob;
};
using DiscLattice = std::vector<LatticeNode>;

/// Lattices of nine or more spots that look like a plane lattice in perspective, largest first. The basis is
/// that of the shortest steps in the image, which on an oblique board may not be the board's own.
/// @param is_bright  spots that are brighter than their surroundings
/// @param window_share  neighbourhood with which spots are compared, as a share of the shorter side
[[nodiscard]] std::vector<DiscLattice> findLattices(const GrayImage& image, bool is_bright,
                                                    double window_share);

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

/// The placement whose columns point most to the right, or downwards if steeper; null if there is none.
[[nodiscard]] const GridPlacement* chosenPlacement(const std::vector<GridPlacement>& placements,
                                                   const CircleCounts& asked);

}  // namespace alidade
