// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "alidade/core/image.h"

namespace alidade {

/// One observed board point. Pixel (0, 0) is the centre of the top-left pixel.
struct Corner {
  int id = 0;                   ///< row * columns + column, see Checkerboard
  Eigen::Vector2d pixel{0, 0};  ///< its observed position
  double sigma_px =
      std::numeric_limits<double>::quiet_NaN();  ///< standard deviation of each coordinate; NaN = unknown
};

/// One image of a board by one camera. Functions that return views order the corners by id, each at most
/// once; calibrate() sorts what it is given.
struct View {
  std::string image = {};  ///< name or path, for messages and files; unique
  ImageSize size = {};     ///< of the image, in pixels; as in camera files
  std::vector<Corner> corners = {};
};

}  // namespace alidade
