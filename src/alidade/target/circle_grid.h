// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <numbers>
#include <optional>
#include <string_view>

#include <Eigen/Core>

#include "alidade/target/board_field.h"

namespace alidade {

/// Discs in columns and rows, dark on bright or bright on dark. Columns and rows count discs; ids run along
/// the columns first, and the frame is that of a Checkerboard, with the origin at the centre of disc 0.
struct CircleGrid {
  static constexpr std::string_view kName = "circles";
  static constexpr std::string_view kExample =
      "circles:10x8:25mm:15mm (columns x rows of circles, the distance of neighbours, the diameter)";
  static constexpr BoardWords kWords = {
      .counted = "circles", .points = "circles", .certain = "an asymmetric grid with an odd number of rows"};
  static constexpr BoardPattern kPattern = BoardPattern::kDiscs;

  int columns = 0;
  int rows = 0;
  double spacing_m = 0;
  double diameter_m = 0;

  static auto fields() {
    return std::array{BoardField<CircleGrid>{"spacing", &CircleGrid::spacing_m},
                      BoardField<CircleGrid>{"diameter", &CircleGrid::diameter_m}};
  }
  [[nodiscard]] std::optional<BoardFault> fault() const;

  [[nodiscard]] PointLayout layout() const {
    return {.columns = columns,
            .rows = rows,
            .spacing_m = spacing_m,
            .margin_m = 0.5 * diameter_m,
            .disc_radius_m = 0.5 * diameter_m,
            .symmetry_step = symmetryStep()};
  }
  [[nodiscard]] std::optional<MarkerIds> markers() const { return std::nullopt; }
  /// The centre of a disc on the board, metres.
  [[nodiscard]] Eigen::Vector3d corner(int id) const {
    return {spacing_m * (id % columns), spacing_m * (id / columns), 0.0};
  }
  /// See Board::symmetryStep().
  [[nodiscard]] int symmetryStep() const { return columns == rows ? 1 : 2; }

  friend bool operator==(const CircleGrid&, const CircleGrid&) = default;
};

/// OpenCV's asymmetric grid: rows of discs, every other one shifted by half the distance of its discs, which
/// is twice the spacing; rows are one spacing apart. Columns count the discs of a row. With an odd number of
/// rows, its orientation is unambiguous.
struct AsymmetricCircleGrid {
  static constexpr std::string_view kName = "acircles";
  static constexpr std::string_view kExample =
      "acircles:4x11:20mm:14mm (circles a row x rows, the distance of rows, the diameter)";
  static constexpr BoardWords kWords = {
      .counted = "circles", .points = "circles", .certain = "a grid with an odd number of rows"};
  static constexpr BoardPattern kPattern = BoardPattern::kStaggeredDiscs;

  int columns = 0;
  int rows = 0;
  double spacing_m = 0;
  double diameter_m = 0;

  static auto fields() {
    return std::array{BoardField<AsymmetricCircleGrid>{"spacing", &AsymmetricCircleGrid::spacing_m},
                      BoardField<AsymmetricCircleGrid>{"diameter", &AsymmetricCircleGrid::diameter_m}};
  }
  [[nodiscard]] std::optional<BoardFault> fault() const;

  [[nodiscard]] PointLayout layout() const {
    return {.columns = columns,
            .rows = rows,
            .spacing_m = std::numbers::sqrt2 * spacing_m,
            .margin_m = 0.5 * diameter_m,
            .disc_radius_m = 0.5 * diameter_m,
            .symmetry_step = symmetryStep()};
  }
  [[nodiscard]] std::optional<MarkerIds> markers() const { return std::nullopt; }
  [[nodiscard]] Eigen::Vector3d corner(int id) const {
    const int row = id / columns;
    return {spacing_m * (2 * (id % columns) + row % 2), spacing_m * row, 0.0};
  }
  [[nodiscard]] int symmetryStep() const { return rows % 2 == 0 ? 2 : 4; }

  friend bool operator==(const AsymmetricCircleGrid&, const AsymmetricCircleGrid&) = default;
};

}  // namespace alidade
