// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "alidade/core/image.h"

namespace alidade {

/// An observed board point; for a circle grid, the centroid of the image of a disc. Pixel (0, 0) is the
/// centre of the top-left pixel.
struct Corner {
  int id = 0;                   ///< row * columns + column, see Checkerboard
  Eigen::Vector2d pixel{0, 0};  ///< its observed position
  double sigma_px =
      std::numeric_limits<double>::quiet_NaN();  ///< standard deviation of each coordinate; NaN = unknown
};

/// False if the pixel is further outside the image than noise and an extrapolating detector explain: 2 % of
/// the longer side. Then the stated size belongs to another image, or width and height are swapped.
[[nodiscard]] inline bool isInOrNearImage(const Eigen::Vector2d& pixel, const ImageSize& size) {
  constexpr double kNear = 0.02;
  const Eigen::Vector2d sides(size.width, size.height);
  const Eigen::Vector2d from_centre = (pixel - 0.5 * (sides - Eigen::Vector2d::Ones())).cwiseAbs();
  return (from_centre - 0.5 * sides).maxCoeff() <= kNear * sides.maxCoeff();
}

/// One board in one image of a camera. Functions that return views order the corners by id, each at most
/// once; calibrate() sorts its input.
struct View {
  std::string image = {};  ///< name or path, for messages and files; unique for each board
  ImageSize size = {};     ///< of the image, in pixels; as in camera files
  std::vector<Corner> corners = {};
  std::size_t board = 0;  ///< index of the board among the given boards
};

}  // namespace alidade
