// SPDX-License-Identifier: MIT
#pragma once

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

}  // namespace alidade
