// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include <Eigen/Core>

#include "alidade/imagery/remap_table.h"

namespace alidade {

/// Source pixels over a rectangle of output pixels as a polynomial of degree 5 in each coordinate, through
/// the values at 6 x 6 places, the Chebyshev points of the rectangle with its rim. Coordinates s (across) and
/// t (down) go from -1 to 1 between the centres of the outer pixels.
class TilePolynomial {
 public:
  static constexpr std::size_t kNumNodes = 6;
  static constexpr int kMinSide = 8;  ///< pixels of a rectangle at least, either way

  /// Places of the nodes, rising from -1 to 1.
  [[nodiscard]] static const std::array<double, kNumNodes>& nodes();
  /// Places between them, where an interpolation errs most.
  [[nodiscard]] static const std::array<double, kNumNodes - 1>& middles();

  /// @param values  at the nodes, rows one after another; kNumNodes^2
  explicit TilePolynomial(std::span<const Eigen::Vector2d> values);

  /// Values at many places: x[i] and y[i] at (s[i], t[i]), in whole groups of kGroup.
  static constexpr std::size_t kGroup = 4;
  void evaluate(std::span<const double> s, std::span<const double> t, double* x, double* y) const;

  [[nodiscard]] Eigen::Vector2d centre() const { return {coefficients_[0], coefficients_[1]}; }
  /// Bound of how far any value lies from that at the centre, by coordinates.
  [[nodiscard]] Eigen::Vector2d spread() const;

  /// Values at the pixels of the rectangle, as floats. What floats round, beside the result itself, is the
  /// distance to the middle of the row.
  /// @param out  the rectangle's first pixel; rows follow one another `stride` apart
  void write(int width, int height, SourcePixel* out, std::ptrdiff_t stride) const;

 private:
  // x and y of the coefficients of s^i t^j at 2 (i + kNumNodes j).
  std::array<double, 2 * kNumNodes * kNumNodes> coefficients_{};
};

}  // namespace alidade
