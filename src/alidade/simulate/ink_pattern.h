// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "alidade/target/board_ink.h"
#include "alidade/target/board_kinds.h"

namespace alidade {

/// A print and the white paper around it, in the board frame, metres. Marks are found through the cells of a
/// grid.
class InkPattern {
 public:
  /// A dark box, or the disc that fills it.
  struct Mark {
    Eigen::AlignedBox2d box;
    bool is_disc = false;

    [[nodiscard]] bool contains(const Eigen::Vector2d& p) const {
      return is_disc ? (p - box.center()).norm() <= 0.5 * box.sizes().x() : box.contains(p);
    }
  };

  /// Any print, on paper with a margin of a tenth of the longer side.
  explicit InkPattern(const BoardInk& ink);
  /// The (columns + 1) x (rows + 1) squares around the inner corners, on paper with a margin of one square.
  /// The square between the corners (0, 0) and (1, 1) is dark, and so is its diagonal neighbour beyond corner
  /// 0, which identifies corner 0. `border_square`: see RenderOptions.
  explicit InkPattern(const Checkerboard& board, double border_square = 1);

  [[nodiscard]] const Eigen::AlignedBox2d& paper() const { return paper_; }
  /// False for anything not finite.
  [[nodiscard]] bool isDark(const Eigen::Vector2d& p) const;
  /// Writes the marks whose boxes touch `window`, each once; `out` is overwritten. Returns false, with `out`
  /// incomplete, for a window of many cells or marks.
  [[nodiscard]] bool findFewIn(const Eigen::AlignedBox2d& window, std::vector<const Mark*>& out) const;

 private:
  InkPattern(const BoardInk& ink, double margin_m);

  // The cell of a place, or the nearest one for a place outside.
  [[nodiscard]] Eigen::Vector2i cellAt(const Eigen::Vector2d& p) const;
  [[nodiscard]] const std::vector<std::uint32_t>& marksOfCell(int x, int y) const {
    return cells_[static_cast<std::size_t>(y * num_cells_.x() + x)];
  }

  Eigen::AlignedBox2d extent_;
  Eigen::AlignedBox2d paper_;
  Eigen::Vector2i num_cells_;
  double cell_m_ = 0;
  std::vector<Mark> marks_;
  std::vector<std::vector<std::uint32_t>> cells_;  // indices of the marks that touch each cell
};

}  // namespace alidade
