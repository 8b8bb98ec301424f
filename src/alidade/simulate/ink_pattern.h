// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
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
  [[nodiscard]] BoardTone tone(const Eigen::Vector2d& p) const {
    if (!paper_.contains(p)) return BoardTone::kBackground;  // also for NaN
    if (!extent_.contains(p)) return BoardTone::kBright;
    const bool is_dark =
        std::ranges::any_of(marksIn(cellAt(p)), [&](const Mark& mark) { return mark.contains(p); });
    return is_dark ? BoardTone::kDark : BoardTone::kBright;
  }
  /// A lower bound of the distance to the nearest place with a different tone, metres.
  [[nodiscard]] double edgeDistance(const Eigen::Vector2d& p) const;

 private:
  // The cell of a place, or the nearest one for a place outside.
  [[nodiscard]] Eigen::Vector2i cellAt(const Eigen::Vector2d& p) const {
    const Eigen::Vector2d at = ((p - extent_.min()) / cell_m_).array().floor();
    const Eigen::Vector2d last = (num_cells_.array() - 1).cast<double>();
    return at.cwiseMax(0.0).cwiseMin(last).cast<int>();
  }
  struct Mark {
    Eigen::AlignedBox2d box;
    bool is_disc = false;  // a disc that fills the box

    [[nodiscard]] bool contains(const Eigen::Vector2d& p) const {
      return is_disc ? (p - box.center()).norm() <= 0.5 * box.sizes().x() : box.contains(p);
    }
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
