// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

#include "alidade/core/image.h"
#include "alidade/geometry/dense_matrix.h"

namespace alidade {

/// The pixel of image b that corresponds to a pixel of image a, if b is a rotated by quarter turns and
/// resized: pixel_b = b_from_a * pixel_a + offset, sizes scaling as c -> s (c + 0.5) - 0.5 on each axis.
struct ImageMatch {
  int quarter_turns = 0;  ///< clockwise, from a to b: 0 to 3
  UnalignedMatrix2d b_from_a = UnalignedMatrix2d::Identity();
  Eigen::Vector2d offset = Eigen::Vector2d::Zero();
  /// Lengths are in pixels of the finer of the two images, along a's axes, so they do not depend on the order
  /// of the images.
  UnalignedMatrix2d unit_from_a = UnalignedMatrix2d::Identity();
  UnalignedMatrix2d unit_from_b = UnalignedMatrix2d::Identity();
  ImageSize unit_size{};  ///< of the finer image

  [[nodiscard]] Eigen::Vector2d inB(const Eigen::Vector2d& pixel_a) const {
    return b_from_a * pixel_a + offset;
  }
  /// The rotation of the camera frame that matches the rotation of the image: x right and y down in both.
  [[nodiscard]] Eigen::Matrix3d frameTurn() const;
};

/// The numbers of quarter turns (0 to 3) after which images of these sizes have the same shape; empty if no
/// rotation matches them. Sides may differ by one pixel because resizing rounds them.
[[nodiscard]] std::vector<int> possibleTurns(ImageSize a, ImageSize b);

/// @pre `quarter_turns` is one of possibleTurns()
[[nodiscard]] ImageMatch matchImages(ImageSize a, ImageSize b, int quarter_turns);

/// Pixels of image a, row by row, from border to border of the coarser image (centres of its outermost
/// pixels).
struct MatchedGrid {
  int columns = 0;
  int rows = 0;
  std::vector<Eigen::Vector2d> pixels;
};

/// @param columns, rows  numbers of pixels; 0: 40 along the longer side, with square cells
[[nodiscard]] MatchedGrid matchedGrid(ImageSize a, ImageSize b, const ImageMatch& match, int columns = 0,
                                      int rows = 0);

}  // namespace alidade
