// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <limits>

#include "alidade/camera/any_camera.h"

namespace alidade {

struct GridDifference {
  double worst_px = 0;  ///< infinite if `other` does not see a point that the camera sees
  int num_points = 0;
};

/// How differently `other` projects what a camera sees in 40 x 30 pixels from border to border of its image.
inline GridDifference gridDifference(const AnyCamera& camera, const AnyCamera& other, ImageSize size) {
  constexpr int kColumns = 40;
  constexpr int kRows = 30;
  GridDifference difference;
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      const Eigen::Vector2d pixel((size.width - 1.0) * column / (kColumns - 1),
                                  (size.height - 1.0) * row / (kRows - 1));
      const auto ray = camera.unproject(pixel);
      if (!ray) continue;
      const Projection ours = camera.project(*ray);
      if (!ours.ok()) continue;  // on the rim of the domain
      const Projection theirs = other.project(*ray);
      const double error =
          theirs.ok() ? (theirs.pixel - ours.pixel).norm() : std::numeric_limits<double>::infinity();
      difference.worst_px = std::max(difference.worst_px, error);
      ++difference.num_points;
    }
  }
  return difference;
}

}  // namespace alidade
