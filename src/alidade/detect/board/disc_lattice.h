// SPDX-License-Identifier: MIT
#pragma once

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

}  // namespace alidade
