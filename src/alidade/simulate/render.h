// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"
#include "alidade/core/cancel.h"
#include "alidade/core/image.h"
#include "alidade/geometry/se3.h"
#include "alidade/record/scene.h"
#include "alidade/simulate/ink_pattern.h"
#include "alidade/simulate/ray_lattice.h"
#include "alidade/target/board_ink.h"
#include "alidade/target/board_kinds.h"

namespace alidade {

/// The tones of a checkerboard. Around columns x rows inner corners lie (columns + 1) x (rows + 1) squares.
/// The square between the corners (0, 0) and (1, 1) is dark, and so is its diagonal neighbour beyond corner
/// 0, which identifies corner 0. Places are in the board frame, in squares.
class SquaresPattern {
 public:
  /// `border_square`: see RenderOptions.
  SquaresPattern(const Checkerboard& board, double border_square = 1)
      : board_(board), border_square_(border_square) {}

  [[nodiscard]] double unit() const { return board_.square_m; }  ///< metres
  /// The tone of a place; anything not finite is background.
  [[nodiscard]] BoardTone tone(const Eigen::Vector2d& p) const {
    const Eigen::Array2d beyond = beyondSquares(p);
    // Rejects NaN too, and comes before the conversion to int, for which the value must be in range.
    if (!(beyond.x() < 1 && beyond.y() < 1)) return BoardTone::kBackground;
    if (beyond.x() >= 0 || beyond.y() >= 0) return BoardTone::kBright;
    const int i = static_cast<int>(p.x() + 1);  // from 0 at the outermost square
    const int j = static_cast<int>(p.y() + 1);
    return (i + j) % 2 == 0 ? BoardTone::kDark : BoardTone::kBright;
  }
  /// Distance in squares to the nearest line across which the tone may change; closer places all have the
  /// same tone. All sides of squares count, also those between a bright square and the margin. NaN for NaN.
  [[nodiscard]] double edgeDistance(const Eigen::Vector2d& p) const;

 private:
  // Distance by which a place is outside the squares, along both axes; negative if inside.
  [[nodiscard]] Eigen::Array2d beyondSquares(const Eigen::Vector2d& p) const {
    return {std::max(-border_square_ - p.x(), p.x() - (board_.columns - 1 + border_square_)),
            std::max(-border_square_ - p.y(), p.y() - (board_.rows - 1 + border_square_))};
  }

  Checkerboard board_;
  double border_square_;
};

/// Spread of the light of a point along an axis of the image: a Gaussian of standard deviation `blur_px`
/// convolved with the pixel's width of 1. Returns the share of the light left of `x_px`.
[[nodiscard]] double pointSpreadShare(double x_px, double blur_px);

/// Places of equal weight over which the light of a pixel is averaged, relative to its centre, in pixels.
///
/// A Fibonacci lattice (a rank-1 lattice of F_k points with generator F_{k-1}; Niederreiter 1992, section 5)
/// mapped by the inverse of pointSpreadShare(). Each axis has as many different coordinates as there are
/// places, so that an edge along an axis is off by at most half a sample. The lattice is symmetric about the
/// centre, so that it shifts no edge.
struct PointSpread {
  std::vector<double> x;
  std::vector<double> y;
  double radius_px = 0;  ///< of the place farthest from the centre

  [[nodiscard]] std::size_t size() const { return x.size(); }
};

/// At least `min_samples` places: the number is raised to the next Fibonacci number.
/// `blur_px` >= 0, `min_samples` in [1, 1e6].
[[nodiscard]] PointSpread makePointSpread(double blur_px, int min_samples);

/// Renders views of boards by one camera: the board and its margin (see SquaresPattern, InkPattern) in front
/// of a uniform background. A board seen from behind is background; pixels without a ray get no light.
///
/// The light of a pixel is the mean over its point spread, each place of which is traced to the board's plane
/// by the expansion of RayLattice; light from across the rim of the domain is not modelled. Shading is
/// evaluated at pixel centres. Noise is normal, which approximates shot noise above about ten electrons.
class Renderer {
 public:
  /// Traces the camera's rays once. Both sides of `size` must be positive.
  Renderer(const AnyCamera& camera, ImageSize size, int num_jobs = 0) : rays_(camera, size, num_jobs) {}

  /// The same bytes for the same arguments, regardless of the number of threads.
  /// @throws Error (kInput) for options out of range; Cancelled once `cancel` is set.
  [[nodiscard]] GrayImage render(const Checkerboard& board, const SE3& camera_from_board,
                                 const RenderOptions& options, const CancelFlag* cancel = nullptr) const;
  /// The same for any print; border_square does not apply.
  [[nodiscard]] GrayImage render(const BoardInk& ink, const SE3& camera_from_board,
                                 const RenderOptions& options, const CancelFlag* cancel = nullptr) const;

 private:
  RayLattice rays_;
};

}  // namespace alidade
