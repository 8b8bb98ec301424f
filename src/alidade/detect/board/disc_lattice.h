// SPDX-License-Identifier: MIT
#pragma once

#include <map>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "alidade/core/image.h"

namespace alidade {

/// A spot that is about as an ellipse.
struct Blob {
  Eigen::Vector2d pixel;  ///< its centroid
  Eigen::Matrix2d shape;  ///< see DiscGuess
  double area_px = 0;
};

/// A blob at a place of a lattice, counted along its two directions from an arbitrary origin; the second
/// direction is clockwise of the first, as the image is seen.
struct LatticeNode {
  int i = 0;
  int j = 0;
  Blob blob;
};
using DiscLattice = std::vector<LatticeNode>;

/// Spots that lie as on a plane lattice in perspective, every lattice of nine or more; the largest first. The
/// basis is that of the shortest steps in the image, which on an oblique board may not be the board's own.
/// @param is_bright  spots that are brighter than what is around them
/// @param window_share  the neighbourhood that spots are compared with, as a share of the shorter side
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
