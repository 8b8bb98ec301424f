// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace alidade {

/// The printed pattern of a board on white paper, in the board frame, metres. All of it lies in the extent.
struct BoardInk {
  std::vector<Eigen::AlignedBox2d> boxes;       ///< dark; none overlap
  Eigen::AlignedBox2d extent;                   ///< of the whole pattern, including its bright squares
  std::vector<Eigen::AlignedBox2d> discs = {};  ///< dark, each given by its bounding square; none overlap
};

}  // namespace alidade
