// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <vector>

#include "alidade/camera/any_camera.h"
#include "alidade/core/cancel.h"
#include "alidade/core/image.h"
#include "alidade/geometry/se3.h"
#include "alidade/record/scene.h"
#include "alidade/simulate/ray_lattice.h"
#include "alidade/target/board_ink.h"
#include "alidade/target/board_kinds.h"

namespace alidade {

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

/// Renders views of boards by one camera: the board and its margin (see InkPattern) in front of a uniform
/// background. A board seen from behind is background; pixels without a ray get no light.
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
