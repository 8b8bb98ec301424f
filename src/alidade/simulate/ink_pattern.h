// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "alidade/target/board_ink.h"

namespace alidade {

/// Tones of places on the plane of the board.
enum class BoardTone {
  kDark,        ///< a dark square
  kBright,      ///< a bright square, or the paper's margin around the squares, one square wide
  kBackground,  ///< beyond the paper
};

/// The tones of any print, with a white margin a tenth of its longer side wide. Marks are found through the
/// cells of a grid.
class InkPattern {
 public:
  explicit InkPattern(const BoardInk& ink);

  [[nodiscard]] double unit() const { return 1; }  ///< metres
  [[nodiscard]] BoardTone tone(const Eigen::Vector2d& p) const;
  /// A lower bound of the distance to the nearest place with a different tone, metres.
  [[nodiscard]] double edgeDistance(const Eigen::Vector2d& p) const;

 private:
  [[nodiscard]] Eigen::Vector2i cellAt(const Eigen::Vector2d& p) const;
  struct Mark {
    Eigen::AlignedBox2d box;
    bool is_disc = false;  // a disc that fills the box

    [[nodiscard]] bool contains(const Eigen::Vector2d& p) const;
    [[nodiscard]] double edgeDistance(const Eigen::Vector2d& p) const;
  };
  void add(const Mark& mark);
  [[nodiscard]] const std::vector<Mark>& marksIn(const Eigen::Vector2i& cell) const {
    return cells_[static_cast<std::size_t>(cell.y() * num_cells_.x() + cell.x())];
  }

  Eigen::AlignedBox2d extent_;
  Eigen::AlignedBox2d paper_;
  Eigen::Vector2i num_cells_;
  double cell_m_ = 0;
  std::vector<std::vector<Mark>> cells_;  // marks that touch each cell
};

}  // namespace alidade
