// SPDX-License-Identifier: MIT
#include "alidade/detect/corner_order.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

namespace alidade {
namespace {

using Eigen::Vector2d;

std::optional<double> sample(const GrayImage& image, const Vector2d& p) {
  const int x = static_cast<int>(std::lround(p.x()));
  const int y = static_cast<int>(std::lround(p.y()));
  if (x < 0 || y < 0 || x >= image.size.width || y >= image.size.height) return std::nullopt;
  return image.at(x, y);
}

const Vector2d& at(const Checkerboard& board, const CornerGrid& grid, int column, int row) {
  return grid[static_cast<std::size_t>(row * board.columns + column)];
}

CornerGrid mirroredColumns(const Checkerboard& board, const CornerGrid& grid) {
  CornerGrid out;
  for (int row = 0; row < board.rows; ++row) {
    for (int column = board.columns - 1; column >= 0; --column) out.push_back(at(board, grid, column, row));
  }
  return out;
}

double turn(const Vector2d& a, const Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

// One line of corners that would follow on a side: position along the line and how far outside (1 = next
// line).
struct Side {
  bool along_columns;  // the line runs along the columns (top and bottom)
  bool at_start;       // before index 0 (left and top)
};
constexpr std::array<Side, 4> kSides = {{{false, true}, {true, true}, {false, false}, {true, false}}};

}  // namespace

BoardContrast measureContrast(const GrayImage& image, const Checkerboard& board, const CornerGrid& grid) {
  std::array<double, 2> sum{};
  std::array<int, 2> count{};
  for (int row = 0; row + 1 < board.rows; ++row) {
    for (int column = 0; column + 1 < board.columns; ++column) {
      const Vector2d middle =
          0.25 * (at(board, grid, column, row) + at(board, grid, column + 1, row) +
                  at(board, grid, column, row + 1) + at(board, grid, column + 1, row + 1));
      const auto level = sample(image, middle);
      if (!level) continue;
      const auto parity = static_cast<std::size_t>((row + column) % 2);
      sum[parity] += *level;
      ++count[parity];
    }
  }
  return {.first = count[0] > 0 ? sum[0] / count[0] : 0.0, .second = count[1] > 0 ? sum[1] / count[1] : 0.0};
}

CornerGrid orderCorners(const GrayImage& image, const Checkerboard& board, CornerGrid grid) {
  const auto along_columns = [&] {
    return Vector2d(at(board, grid, board.columns - 1, 0) - at(board, grid, 0, 0) +
                    at(board, grid, board.columns - 1, board.rows - 1) - at(board, grid, 0, board.rows - 1));
  };
  const auto along_rows = [&] {
    return Vector2d(at(board, grid, 0, board.rows - 1) - at(board, grid, 0, 0) +
                    at(board, grid, board.columns - 1, board.rows - 1) -
                    at(board, grid, board.columns - 1, 0));
  };
  if (turn(along_columns(), along_rows()) < 0) grid = mirroredColumns(board, grid);

  bool reverse = false;
  if (board.isAmbiguous()) {
    // A square board could also be turned by 90 degrees; the columns are what runs most to the right.
    if (board.columns == board.rows && std::abs(along_columns().x()) < std::abs(along_rows().x())) {
      CornerGrid turned;
      for (int row = 0; row < board.rows; ++row) {
        for (int column = 0; column < board.columns; ++column) {
          turned.push_back(at(board, grid, row, board.rows - 1 - column));
        }
      }
      grid = turned;
    }
    const Vector2d x_axis = along_columns();
    reverse = std::abs(x_axis.x()) >= std::abs(x_axis.y()) ? x_axis.x() < 0 : x_axis.y() < 0;
  } else {
    const BoardContrast contrast = measureContrast(image, board, grid);
    reverse = contrast.first > contrast.second;
  }
  if (reverse) std::reverse(grid.begin(), grid.end());
  return grid;
}

std::vector<int> sidesThatContinue(const GrayImage& image, const Checkerboard& board,
                                   const CornerGrid& grid) {
  const BoardContrast contrast = measureContrast(image, board, grid);
  const double step_needed = 0.4 * std::abs(contrast.first - contrast.second);
  std::vector<int> sides;
  for (int side = 0; side < 4; ++side) {
    const auto [along_columns, at_start] = kSides[static_cast<std::size_t>(side)];
    const int line_length = along_columns ? board.columns : board.rows;
    const int depth = along_columns ? board.rows : board.columns;
    // Corner i of the line that lies `inside` lines from the rim; -1 is the line looked for.
    const auto corner = [&](int i, int inside) {
      const int k = at_start ? inside : depth - 1 - inside;
      return along_columns ? at(board, grid, i, k) : at(board, grid, k, i);
    };
    int num_seen = 0;
    int num_crossings = 0;
    for (int i = 0; i < line_length; ++i) {
      const Vector2d next = 3 * corner(i, 0) - 3 * corner(i, 1) + corner(i, 2);
      const Vector2d outwards = 0.4 * (next - corner(i, 0));
      const Vector2d sideways = 0.4 * (i + 1 < line_length ? Vector2d(corner(i + 1, 0) - corner(i, 0))
                                                           : Vector2d(corner(i, 0) - corner(i - 1, 0)));
      const auto q0 = sample(image, next + outwards + sideways);
      const auto q1 = sample(image, next + outwards - sideways);
      const auto q2 = sample(image, next - outwards - sideways);
      const auto q3 = sample(image, next - outwards + sideways);
      if (!q0 || !q1 || !q2 || !q3) continue;
      ++num_seen;
      const bool bright_diagonal = std::min(*q0, *q2) - std::max(*q1, *q3) > step_needed;
      const bool dark_diagonal = std::min(*q1, *q3) - std::max(*q0, *q2) > step_needed;
      if (bright_diagonal || dark_diagonal) ++num_crossings;
    }
    if (2 * num_seen >= line_length && 10 * num_crossings >= 7 * num_seen) sides.push_back(side);
  }
  return sides;
}

double localSpacing(const Checkerboard& board, const CornerGrid& grid, int id) {
  const int column = id % board.columns;
  const int row = id / board.columns;
  const Vector2d& here = at(board, grid, column, row);
  double nearest = std::numeric_limits<double>::infinity();
  if (column > 0) nearest = std::min(nearest, (at(board, grid, column - 1, row) - here).norm());
  if (column + 1 < board.columns)
    nearest = std::min(nearest, (at(board, grid, column + 1, row) - here).norm());
  if (row > 0) nearest = std::min(nearest, (at(board, grid, column, row - 1) - here).norm());
  if (row + 1 < board.rows) nearest = std::min(nearest, (at(board, grid, column, row + 1) - here).norm());
  return nearest;
}

}  // namespace alidade
