// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <optional>
#include <string_view>

#include <Eigen/Core>

#include "alidade/target/board_field.h"

namespace alidade {

/// A flat checkerboard of columns x rows inner corners. Corner ids run along the columns first:
/// id = row * columns + column. Board frame: origin at corner 0, x along the columns, y along the rows, z
/// into the board; metres.
struct Checkerboard {
  static constexpr std::string_view kName = "checkerboard";
  static constexpr std::string_view kExample =
      "checkerboard:9x6:25mm (columns x rows of inner corners, then the side of a square)";
  static constexpr BoardWords kWords = {
      .counted = "inner corners", .points = "corners", .certain = "a board with one even and one odd count"};
  static constexpr BoardPattern kPattern = BoardPattern::kSquares;

  int columns = 0;
  int rows = 0;
  double square_m = 0;

  static auto fields() { return std::array{BoardField<Checkerboard>{"square", &Checkerboard::square_m}}; }
  [[nodiscard]] std::optional<BoardFault> fault() const;

  [[nodiscard]] PointLayout layout() const {
    return {.columns = columns,
            .rows = rows,
            .spacing_m = square_m,
            .margin_m = square_m,
            .symmetry_step = symmetryStep()};
  }
  [[nodiscard]] std::optional<MarkerIds> markers() const { return std::nullopt; }
  [[nodiscard]] int numCorners() const { return columns * rows; }

  /// The position of corner `id` on the board, metres.
  [[nodiscard]] Eigen::Vector3d corner(int id) const {
    const int column = id % columns;
    const int row = id / columns;
    return {square_m * column, square_m * row, 0.0};
  }

  /// The centre of the corners on the board, metres.
  [[nodiscard]] Eigen::Vector3d middle() const { return 0.5 * corner(numCorners() - 1); }

  /// True if a rotated board shows the same pattern of black and white: both counts even or both odd. No
  /// detector can then identify the orientation.
  [[nodiscard]] bool isAmbiguous() const { return (columns - rows) % 2 == 0; }

  /// The smallest number of quarter turns after which the pattern looks the same: 4 for unambiguous boards, 2
  /// for ambiguous ones, 1 for square ones with even counts. A quarter turn of a square board with odd counts
  /// swaps the colours.
  [[nodiscard]] int symmetryStep() const {
    if (!isAmbiguous()) return 4;
    return columns == rows && columns % 2 == 0 ? 1 : 2;
  }

  /// True if the colours identify corner 0, up to the symmetry of the board: its inner square (between
  /// corners (0, 0) and (1, 1)) is dark. On other boards this square may have either colour.
  [[nodiscard]] bool coloursTellCorner0() const {
    return !isAmbiguous() || (columns == rows && columns % 2 == 1);
  }

  friend bool operator==(const Checkerboard&, const Checkerboard&) = default;
};

}  // namespace alidade
