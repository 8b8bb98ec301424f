// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "alidade/target/board_field.h"

namespace alidade {

/// OpenCV's sets of square markers.
struct MarkerDictionary {
  std::string_view name;  ///< as in OpenCV: "DICT_4X4_50"
  int num_markers = 0;
  int num_bits = 0;   ///< along a side, without the border
  int opencv_id = 0;  ///< its value in OpenCV's enumeration
};

/// Nothing for a name that OpenCV 4.6 does not have.
[[nodiscard]] std::optional<MarkerDictionary> findMarkerDictionary(std::string_view name);

/// Smaller dictionaries are the first markers of larger ones: "DICT_4X4" for "DICT_4X4_50".
[[nodiscard]] std::string markerFamily(const std::string& dictionary);

/// A checkerboard with a marker in each bright square, so that any visible part can be identified. Columns
/// and rows count squares; its corners are the (columns - 1) x (rows - 1) inner ones, with the ids and the
/// frame of a Checkerboard. Markers are numbered row by row from the top left. There are two layouts, whose
/// first square is dark or bright; both have the same corners.
struct CharucoBoard {
  static constexpr std::string_view kName = "charuco";
  static constexpr std::string_view kExample =
      "charuco:8x11:24mm:18.75mm:DICT_4X4_1000 (columns x rows of squares, the sides of a square and of a "
      "marker, OpenCV's dictionary)";
  static constexpr BoardWords kWords = {
      .counted = "squares", .points = "corners", .marker = "marker", .other_markers = "another dictionary"};
  static constexpr BoardPattern kPattern = BoardPattern::kSquares;

  int columns = 0;
  int rows = 0;
  double square_m = 0;
  double marker_m = 0;
  std::string dictionary = {};

  static auto fields() {
    return std::array{BoardField<CharucoBoard>{"square", &CharucoBoard::square_m},
                      BoardField<CharucoBoard>{"marker", &CharucoBoard::marker_m},
                      BoardField<CharucoBoard>{"dictionary", &CharucoBoard::dictionary}};
  }
  [[nodiscard]] std::optional<BoardFault> fault() const;

  [[nodiscard]] PointLayout layout() const {
    return {.columns = columns - 1, .rows = rows - 1, .spacing_m = square_m, .margin_m = square_m};
  }
  [[nodiscard]] std::optional<MarkerIds> markers() const {
    return MarkerIds{.family = markerFamily(dictionary), .last = numMarkers(true) - 1};
  }
  [[nodiscard]] int numMarkers(bool is_bright_first) const {
    return (columns * rows + (is_bright_first ? 1 : 0)) / 2;
  }
  [[nodiscard]] Eigen::Vector3d corner(int id) const {
    const int across = columns - 1;
    return {square_m * (id % across), square_m * (id / across), 0.0};
  }

  friend bool operator==(const CharucoBoard&, const CharucoBoard&) = default;
};

}  // namespace alidade
