// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace alidade {

/// What is printed of a board on white paper, in the board frame, metres.
struct BoardInk {
  std::vector<Eigen::AlignedBox2d> boxes;       ///< dark; none overlap
  Eigen::AlignedBox2d extent;                   ///< of the whole pattern, its bright squares too
  std::vector<Eigen::AlignedBox2d> discs = {};  ///< dark, each by the square around it; none overlap
};

}  // namespace alidade
