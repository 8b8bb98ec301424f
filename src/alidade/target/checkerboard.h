// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

namespace alidade {

/// A flat checkerboard of columns x rows inner corners. Corner ids run along the columns first:
/// id = row * columns + column. Board frame: origin at corner 0, x along the columns, y along the rows, z
/// into the board; metres.
struct Checkerboard {
  int columns = 0;
  int rows = 0;
  double square_m = 0;

  [[nodiscard]] int numCorners() const { return columns * rows; }

  /// Where corner `id` lies on the board, metres.
  [[nodiscard]] Eigen::Vector3d corner(int id) const {
    const int column = id % columns;
    const int row = id / columns;
    return {square_m * column, square_m * row, 0.0};
  }

  /// True if turning the board by 180 degrees gives the same pattern of black and white: both counts even or
  /// both odd. No detector can then tell which end is which.
  [[nodiscard]] bool isAmbiguous() const { return (columns - rows) % 2 == 0; }

  friend bool operator==(const Checkerboard&, const Checkerboard&) = default;
};

/// All corners by id, metres.
[[nodiscard]] std::vector<Eigen::Vector3d> cornerPositions(const Checkerboard& board);

/// The board's SPEC as the command line takes it: "checkerboard:9x6:25mm".
[[nodiscard]] std::string specText(const Checkerboard& board);

}  // namespace alidade
