// SPDX-License-Identifier: MIT
#include "alidade/simulate/board_pattern.h"

#include <algorithm>
#include <cmath>

namespace alidade {

BoardTone boardTone(const Checkerboard& board, const Eigen::Vector2d& point_board) {
  const double x = point_board.x() / board.square_m;
  const double y = point_board.y() / board.square_m;
  // Written so that NaN fails, and before the conversion to int, for which the value must be in range.
  if (!(x >= -2 && x < board.columns + 1 && y >= -2 && y < board.rows + 1)) return BoardTone::kBackground;
  if (x < -1 || x >= board.columns || y < -1 || y >= board.rows) return BoardTone::kBright;
  const int i = static_cast<int>(x + 1);  // from 0 at the outermost square
  const int j = static_cast<int>(y + 1);
  return (i + j) % 2 == 0 ? BoardTone::kDark : BoardTone::kBright;
}

double edgeDistance(const Checkerboard& board, const Eigen::Vector2d& point_board) {
  const double x = point_board.x() / board.square_m;
  const double y = point_board.y() / board.square_m;
  // How far the point is outside the squares, then outside the paper; negative is inside.
  const double beyond_x = std::max(-1 - x, x - board.columns);
  const double beyond_y = std::max(-1 - y, y - board.rows);
  const auto distanceToBox = [](double dx, double dy) {
    return dx > 0 && dy > 0 ? std::hypot(dx, dy) : std::abs(std::max(dx, dy));
  };
  const double to_paper = distanceToBox(beyond_x - 1, beyond_y - 1);
  double distance = to_paper;
  if (beyond_x <= 0 && beyond_y <= 0) {
    distance = std::min(std::abs(x - std::round(x)), std::abs(y - std::round(y)));
  } else if (beyond_x <= 1 && beyond_y <= 1) {
    distance = std::min(distanceToBox(beyond_x, beyond_y), to_paper);
  }
  return distance * board.square_m;
}

}  // namespace alidade
