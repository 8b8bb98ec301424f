// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

namespace alidade {

/// A corner of a board in an image, and its reprojection error.
struct CornerError {
  int id = 0;
  Eigen::Vector2d pixel{0, 0};     ///< observed position
  Eigen::Vector2d error_px{0, 0};  ///< projected minus observed
};

}  // namespace alidade
