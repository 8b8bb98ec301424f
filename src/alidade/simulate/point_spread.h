// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <vector>

namespace alidade {

/// How light from one point spreads along an axis of the image: a Gaussian of standard deviation `blur_px`
/// convolved with the pixel's own width of 1. Returns the share of the light left of `x_px`.
[[nodiscard]] double pointSpreadShare(double x_px, double blur_px);

/// Places of equal weight over which a pixel's light is averaged, relative to the pixel's centre, in pixels.
///
/// A Fibonacci lattice (a rank-1 lattice of F_k points with generator F_{k-1}; Niederreiter 1992, section 5)
/// carried through the inverse of pointSpreadShare(). Each axis has as many different coordinates as there
/// are places, so that an edge along an axis is off by at most half a sample; and the lattice is symmetric
/// about the centre, so that it moves no edge.
struct PointSpread {
  std::vector<double> x;
  std::vector<double> y;
  double radius_px = 0;  ///< of the place farthest from the centre

  [[nodiscard]] std::size_t size() const { return x.size(); }
};

/// At least `min_samples` places: the number is raised to the next Fibonacci number.
/// `blur_px` >= 0, `min_samples` in [1, 1e6].
[[nodiscard]] PointSpread makePointSpread(double blur_px, int min_samples);

}  // namespace alidade
