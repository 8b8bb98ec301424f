// SPDX-License-Identifier: MIT
#include "alidade/simulate/ink_pattern.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace alidade {

using Eigen::AlignedBox2d;
using Eigen::Vector2d;
using Eigen::Vector2i;

namespace {

BoardInk inkOfSquares(const Checkerboard& board, double border_square) {
  const Vector2d least = Vector2d::Constant(-border_square);
  const Vector2d most = Vector2d(board.columns, board.rows).array() - 1 + border_square;
  const auto box = [&](const Vector2d& low, const Vector2d& high) {
    return AlignedBox2d(board.square_m * low.cwiseMax(least), board.square_m * high.cwiseMin(most));
  };
  BoardInk ink{.boxes = {}, .extent = box(least, most)};
  for (int row = -1; row < board.rows; ++row) {
    for (int column = -1; column < board.columns; ++column) {
      const Vector2d low(column, row);
      if ((column + row) % 2 == 0) ink.boxes.push_back(box(low, low.array() + 1));
    }
  }
  return ink;
}

}  // namespace

InkPattern::InkPattern(const BoardInk& ink) : InkPattern(ink, 0.1 * ink.extent.sizes().maxCoeff()) {}

InkPattern::InkPattern(const Checkerboard& board, double border_square)
    : InkPattern(inkOfSquares(board, border_square), board.square_m) {}

InkPattern::InkPattern(const BoardInk& ink, double margin_m) : extent_(ink.extent), paper_(ink.extent) {
  const Vector2d margin = Vector2d::Constant(margin_m);
  paper_.min() -= margin;
  paper_.max() += margin;
  for (const AlignedBox2d& box : ink.boxes) marks_.push_back({.box = box});
  for (const AlignedBox2d& disc : ink.discs) marks_.push_back({.box = disc, .is_disc = true});
  // Cells of about one mark each, so that few marks are looked at.
  cell_m_ = std::sqrt(extent_.volume() / static_cast<double>(std::max<std::size_t>(1, marks_.size())));
  num_cells_ = (extent_.sizes() / cell_m_).array().ceil().cast<int>().max(1);
  cells_.resize(static_cast<std::size_t>(num_cells_.x()) * static_cast<std::size_t>(num_cells_.y()));
  for (std::size_t i = 0; i < marks_.size(); ++i) {
    const Vector2i first = cellAt(marks_[i].box.min());
    const Vector2i last = cellAt(marks_[i].box.max());
    for (int y = first.y(); y <= last.y(); ++y) {
      for (int x = first.x(); x <= last.x(); ++x)
        cells_[static_cast<std::size_t>(y * num_cells_.x() + x)].push_back(static_cast<std::uint32_t>(i));
    }
  }
}

Vector2i InkPattern::cellAt(const Vector2d& p) const {
  const Vector2d last = (num_cells_.array() - 1).cast<double>();
  return ((p - extent_.min()) / cell_m_).cwiseMax(0.0).cwiseMin(last).cast<int>();
}

bool InkPattern::isDark(const Vector2d& p) const {
  if (!extent_.contains(p)) return false;  // also for NaN
  const Vector2i cell = cellAt(p);
  return std::ranges::any_of(marksOfCell(cell.x(), cell.y()),
                             [&](std::uint32_t i) { return marks_[i].contains(p); });
}

bool InkPattern::findFewIn(const AlignedBox2d& window, std::vector<const Mark*>& out) const {
  constexpr int kMostCells = 16;
  constexpr std::size_t kMostMarks = 64;
  out.clear();
  if (!extent_.intersects(window)) return true;
  const Vector2i first = cellAt(window.min());
  const Vector2i last = cellAt(window.max());
  const Vector2i num = (last - first).array() + 1;
  if (num.maxCoeff() > kMostCells || num.prod() > kMostCells) return false;
  for (int y = first.y(); y <= last.y(); ++y) {
    for (int x = first.x(); x <= last.x(); ++x) {
      for (const std::uint32_t i : marksOfCell(x, y)) {
        const Mark* mark = &marks_[i];
        if (!mark->box.intersects(window) || std::ranges::find(out, mark) != out.end()) continue;
        if (out.size() == kMostMarks) return false;
        out.push_back(mark);
      }
    }
  }
  return true;
}

}  // namespace alidade
