// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>

#include "alidade/core/lanes.h"

namespace alidade {

/// As many corners as there are lanes, coordinate by coordinate.
struct CornerGroup {
  using Column = std::array<double, kNumLanes>;
  Column x, y, z;      ///< of the board point
  Column u, v;         ///< of the pixel
  Column root_weight;  ///< 0 in the padding of a view's last group
  double radius_m;     ///< of the discs, the same for all; 0 for points
};

/// Room for the columns of a corner's rows: the pose, kMostParams parameters and the error, in whole lanes.
inline constexpr std::size_t kMaxColumns = 40;

/// The columns of a corner's two rows [J r]. Most are in both rows: the pose (its tangent: translation,
/// rotation), the lens and, last, the error. They are followed by the columns of one axis, its focal length
/// and principal point; those of the other axis are zero and left out. A parameter that moves both
/// coordinates of a pixel belongs among the shared columns.
struct RowLayout {
  static constexpr std::size_t kPose = 6;
  static constexpr std::size_t kOwn = 2;

  constexpr explicit RowLayout(std::size_t num_lens)
      : num_shared(kPose + num_lens + 1), width(num_shared + kOwn), size(num_shared + 4) {
    for (std::size_t axis = 0; axis < 2; ++axis) {
      for (std::size_t c = 0; c < num_shared - 1; ++c) column[axis][c] = c < kPose ? c : c + 4;
      column[axis][num_shared - 1] = size - 1;
      column[axis][num_shared] = kPose + axis;
      column[axis][num_shared + 1] = kPose + axis + 2;
    }
  }

  std::size_t num_shared;
  std::size_t width;
  std::size_t size;  ///< of both axes together: pose, parameters, error
  std::array<std::array<std::size_t, kMaxColumns>, 2>
      column{};  ///< index in the full set, of each column in a row of u and of v
};

}  // namespace alidade
