// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

#include "alidade/target/board.h"

namespace alidade {

/// Bend of a nominally flat board: z = bend_x (1 - X^2) + bend_y (1 - Y^2) in the board frame, with X and Y
/// from -1 to 1 between the outermost corners. Boards of paper on glass, foam or wood bend like this under
/// their own weight or through moisture. Points of unevenly printed or glued sheets deviate from this
/// surface, each by its own offset.
struct BoardShape {
  double bend_x_m = 0;  ///< distance of the centre behind the left and right edges, metres
  double bend_y_m = 0;  ///< distance of the centre behind the top and bottom edges, metres
  std::vector<Eigen::Vector3d> offsets_m = {};  ///< of each point, by id, board frame, metres; empty: none

  friend bool operator==(const BoardShape&, const BoardShape&) = default;
};

/// The derivatives of z with respect to bend_x and bend_y at a point of the board plane.
[[nodiscard]] inline Eigen::Vector2d bendProfile(const Board& board, double x, double y) {
  const double X = x / (0.5 * board.span().x()) - 1;
  const double Y = y / (0.5 * board.span().y()) - 1;
  return {1 - X * X, 1 - Y * Y};
}

/// The position of a point of the board plane on the bent board.
[[nodiscard]] inline Eigen::Vector3d onBentBoard(const Board& board, const BoardShape& shape,
                                                 const Eigen::Vector3d& p_flat) {
  const Eigen::Vector2d profile = bendProfile(board, p_flat.x(), p_flat.y());
  return {p_flat.x(), p_flat.y(), shape.bend_x_m * profile.x() + shape.bend_y_m * profile.y()};
}

/// The position of a point of the board, by its id.
[[nodiscard]] inline Eigen::Vector3d pointOn(const Board& board, const BoardShape& shape, int id) {
  const Eigen::Vector3d p = onBentBoard(board, shape, board.corner(id));
  return shape.offsets_m.empty() ? p : Eigen::Vector3d(p + shape.offsets_m[static_cast<std::size_t>(id)]);
}

/// Root mean square of the offsets, metres: per coordinate in the plane, and normal to it; zero without
/// offsets.
[[nodiscard]] inline Eigen::Vector2d offsetRms(const BoardShape& shape) {
  if (shape.offsets_m.empty()) return {0, 0};
  Eigen::Vector2d squares{0, 0};
  for (const Eigen::Vector3d& offset : shape.offsets_m)
    squares += Eigen::Vector2d(0.5 * offset.head<2>().squaredNorm(), offset.z() * offset.z());
  return (squares / static_cast<double>(shape.offsets_m.size())).cwiseSqrt();
}

}  // namespace alidade
