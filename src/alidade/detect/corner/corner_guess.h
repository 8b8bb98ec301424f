// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include <Eigen/Core>

namespace alidade {

/// Positive if b is clockwise from a in the image.
[[nodiscard]] inline double crossProduct(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Approximate position and surroundings of a corner before refinement. Pixels; (0, 0) is the centre of the
/// top left pixel.
struct CornerGuess {
  Eigen::Vector2d pixel;  ///< within about a fifth of the spacing of the corner
  Eigen::Vector2d
      step_u;  ///< to the next corner along the board's columns: the mean of both sides if both exist
  Eigen::Vector2d step_v;  ///< the same along its rows
  /// True if no corner follows along +u, +v, -u, -v: there, the board's border may cut the squares.
  std::array<bool, 4> is_outermost{};
  /// Distance from both lines in which the squares are plain, as a share of the steps; markers may lie
  /// beyond.
  double clear_share = 1;
};

/// A refined corner: the crossing of two edges (EdgeModel) or, if there are too few pixels, the saddle of the
/// grey levels.
struct CornerFit {
  Eigen::Vector2d pixel;
  Eigen::Matrix2d covariance;  ///< px^2
  double sigma_px = 0;         ///< one standard deviation per axis: sqrt(trace(covariance) / 2)
  double blur_px = 0;          ///< one standard deviation of the edges' blur, including the pixel's own width
  /// Grey levels between the bright and the dark squares at the corner: > 0 if the square between step_u and
  /// step_v is dark, < 0 if it is bright.
  double contrast = 0;
  double window = 0;  ///< half size of the window, as a share of the steps
};

}  // namespace alidade
