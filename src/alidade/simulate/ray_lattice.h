// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"
#include "alidade/core/image.h"

namespace alidade {

/// The rays around a pixel to second order: at (x, y) pixels from its centre, the ray is terms * [1, x, y,
/// x^2, x y, y^2], in the camera frame and of nearly unit length.
struct RayExpansion {
  Eigen::Matrix<double, 3, 6> terms = Eigen::Matrix<double, 3, 6>::Zero();
  bool has_ray = false;  ///< the pixel's centre is in the image of the camera's domain
};

/// The rays of all pixels of an image, from exact rays at 25 nodes of each block of 16 x 16 pixels.
///
/// Rays of pixel centres are exact to 1e-5 pixels: where the polynomial through the nodes is worse at a
/// corner of the block, or the domain's rim cuts the block, each pixel and its eight neighbours are
/// unprojected instead. A pixel that lacks one of these neighbours uses the ray of its centre everywhere
/// around it.
///
/// The omitted third order is, at a distance of d pixels and a focal length of f pixels, up to about 1.5 d^3
/// / f^2 pixels under common distortion: 5e-5 for d = 2, f = 500. It is odd in d, so that it nearly vanishes
/// from means over symmetric surroundings.
class RayLattice {
 public:
  /// Both sides of `size` are positive. The blocks are spread over `num_jobs` threads (0: one per processor).
  RayLattice(const AnyCamera& camera, ImageSize size, int num_jobs);

  [[nodiscard]] const AnyCamera& camera() const { return camera_; }
  [[nodiscard]] ImageSize size() const { return size_; }

  /// The expansions of all pixels of row `y`, from left to right; `out` is resized to the image's width.
  void expandRow(int y, std::vector<RayExpansion>& out) const;

 private:
  static constexpr int kBlock = 16;    // pixels along a side
  static constexpr int kNumNodes = 5;  // along a side

  /// Interpolation along one side of a block, on which t runs from -1 to 1.
  struct Basis {
    Eigen::Matrix<double, kNumNodes, 1> nodes;    // their t
    Eigen::Matrix<double, kNumNodes, 2> at_ends;  // weights of the nodes at t = -1 and 1
    // At the centres of the block's pixels: value, first derivative and half the second, per pixel.
    std::array<Eigen::Matrix<double, kNumNodes, 3>, kBlock> at_pixel;

    Basis();
  };
  struct Block {
    bool is_smooth = false;
    std::array<Eigen::Matrix<double, 3, kNumNodes>, kNumNodes> rays;  // if smooth, of a row of nodes each
    std::vector<RayExpansion> pixels;                                 // at the rim, row by row
  };

  [[nodiscard]] Block makeBlock(int block_x, int block_y) const;
  [[nodiscard]] bool matchesAt(const Block& block, const std::array<Eigen::Vector3d, 4>& corner_rays) const;
  [[nodiscard]] std::vector<RayExpansion> expandAtRim(int first_x, int first_y) const;
  void expandSmooth(const Block& block, int first_x, int y, std::vector<RayExpansion>& out) const;

  AnyCamera camera_;
  ImageSize size_;
  int num_blocks_x_;
  Basis basis_;
  std::vector<Block> blocks_;
};

}  // namespace alidade
