// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include <Eigen/Core>

namespace alidade {

/// Positive if b is clockwise of a, as the image is seen.
[[nodiscard]] inline double crossProduct(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// What is known of a corner before it is refined. Pixels; (0, 0) is the centre of the top left pixel.
struct CornerGuess {
  Eigen::Vector2d pixel;  ///< within about a fifth of the spacing of the corner
  Eigen::Vector2d
      step_u;  ///< to the next corner along the board's columns: the mean of both sides where there are
  Eigen::Vector2d step_v;  ///< the same along its rows
  /// True where no corner follows, along +u, +v, -u, -v: the board's border may cut off the squares there.
  std::array<bool, 4> is_outermost{};
  /// How far off both lines the squares show nothing but their colour, as a share of the steps: markers lie
  /// beyond.
  double clear_share = 1;
};

/// A refined corner: of two crossing edges, see EdgeModel, or, where there are too few pixels for that, the
/// saddle of the grey levels.
struct CornerFit {
  Eigen::Vector2d pixel;
  Eigen::Matrix2d covariance;  ///< px^2
  double sigma_px = 0;         ///< one standard deviation an axis: sqrt(trace(covariance) / 2)
  double blur_px = 0;          ///< one standard deviation of the edges' blur, the pixel's own width included
  /// Grey levels between the bright and the dark squares at the corner: > 0 if the square that lies between
  /// step_u and step_v, seen from the corner, is dark, < 0 if it is bright.
  double contrast = 0;
  double window = 0;  ///< half of the window used, as a share of the steps
};

}  // namespace alidade
