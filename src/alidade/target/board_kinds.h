// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include "alidade/core/error.h"

namespace alidade {

/// A part of the SPEC of a kind of board, after the name and counts, in the same order; the key is that of a
/// board file. A member of type double is a length unless it is a share.
template <class Kind>
struct BoardField {
  std::string_view key;
  std::variant<double Kind::*, int Kind::*, std::string Kind::*> member;
  bool is_share = false;     ///< a plain number
  bool is_optional = false;  ///< only the last field; zero or empty if omitted
};

/// Words for the parts of a kind of board, for messages.
struct BoardWords {
  std::string_view counted;       ///< counted in columns and rows: "inner corners"
  std::string_view points;        ///< points that are found: "corners"
  std::string_view marker = {};   ///< part that has an id; empty if there is none
  std::string_view certain = {};  ///< boards of this kind that never look the same after a rotation; empty if
                                  ///< all are unambiguous
};

/// Patterns of boards. Without markers, boards with the same pattern and counts look alike.
enum class BoardPattern { kSquares, kTags, kDiscs, kStaggeredDiscs };

/// The markers of a board: ids of a family in which each id stands for one pattern.
struct MarkerIds {
  std::string family;
  int first = 0;
  int last = 0;
  friend bool operator==(const MarkerIds&, const MarkerIds&) = default;
};

/// The arrangement of the points of a board; metres.
struct PointLayout {
  int columns = 0;
  int rows = 0;
  double spacing_m = 0;      ///< shortest distance between neighbours
  double margin_m = 0;       ///< from the outermost points to the edge of the print
  double disc_radius_m = 0;  ///< see Board::discRadius()
  int symmetry_step = 4;     ///< see Board::symmetryStep()
};

/// A flat checkerboard of columns x rows inner corners. Corner ids run along the columns first:
/// id = row * columns + column. Board frame: origin at corner 0, x along the columns, y along the rows, z
/// into the board; metres.
struct Checkerboard {
  static constexpr std::string_view kName = "checkerboard";
  static constexpr std::string_view kAliases = "chessboard chess checker";
  static constexpr std::string_view kExample =
      "checkerboard:9x6:25mm (columns x rows of inner corners, then the side of a square)";
  static constexpr BoardWords kWords = {
      .counted = "inner corners", .points = "corners", .certain = "a board with one even and one odd count"};
  static constexpr BoardPattern kPattern = BoardPattern::kSquares;

  int columns = 0;
  int rows = 0;
  double square_m = 0;

  static auto fields() { return std::array{BoardField<Checkerboard>{"square", &Checkerboard::square_m}}; }
  [[nodiscard]] std::optional<ErrorDetail> fault() const;

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
/// frame of a Checkerboard. Markers are numbered row by row from the top left, from the first id on. There
/// are two layouts, whose first square is dark or bright; both have the same corners.
struct CharucoBoard {
  static constexpr std::string_view kName = "charuco";
  static constexpr std::string_view kAliases = "charuco_board";
  static constexpr std::string_view kExample =
      "charuco:8x11:24mm:18.75mm:DICT_4X4_1000 (columns x rows of squares, the sides of a square and of a "
      "marker, OpenCV's dictionary)";
  static constexpr BoardWords kWords = {.counted = "squares", .points = "corners", .marker = "marker"};
  static constexpr BoardPattern kPattern = BoardPattern::kSquares;

  int columns = 0;
  int rows = 0;
  double square_m = 0;
  double marker_m = 0;
  std::string dictionary = {};
  int first_id = 0;

  static auto fields() {
    return std::array{
        BoardField<CharucoBoard>{"square", &CharucoBoard::square_m},
        BoardField<CharucoBoard>{"marker", &CharucoBoard::marker_m},
        BoardField<CharucoBoard>{"dictionary", &CharucoBoard::dictionary},
        BoardField<CharucoBoard>{.key = "first_id", .member = &CharucoBoard::first_id, .is_optional = true}};
  }
  [[nodiscard]] std::optional<ErrorDetail> fault() const;

  [[nodiscard]] PointLayout layout() const {
    return {.columns = columns - 1, .rows = rows - 1, .spacing_m = square_m, .margin_m = square_m};
  }
  [[nodiscard]] std::optional<MarkerIds> markers() const {
    return MarkerIds{
        .family = markerFamily(dictionary), .first = first_id, .last = first_id + numMarkers(true) - 1};
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

/// Least and largest gap between tags, as a share of their side.
inline constexpr double kLeastTagGap = 0.1;
inline constexpr double kLargestTagGap = 1;

/// Kalibr's grid of AprilTags of the family 36h11. Columns and rows count tags. Tag ids start at the bottom
/// left of the print and run to the right, then upwards; small squares fill the gaps between tags. Its points
/// are the outer corners of the tags, 2 columns x 2 rows of them; the frame is that of a Checkerboard, with
/// the origin at the top left.
struct AprilGrid {
  static constexpr std::string_view kName = "aprilgrid";
  static constexpr std::string_view kAliases = "apriltag apriltags april apriltag_grid";
  static constexpr std::string_view kExample =
      "aprilgrid:6x6:88mm:0.3 (columns x rows of tags, the side of a tag, the gap as a share of it)";
  static constexpr BoardWords kWords = {.counted = "tags", .points = "tag corners", .marker = "tag"};
  static constexpr BoardPattern kPattern = BoardPattern::kTags;
  static constexpr std::string_view kDictionary = "DICT_APRILTAG_36h11";
  static constexpr bool kIsUpsideDown = true;  ///< as OpenCV draws its tags
  /// Widths of the black border of a tag, in cells; Kalibr's first.
  static constexpr std::array kBorders = {2, 1, 3, 4, 5, 6, 7, 8};

  int columns = 0;
  int rows = 0;
  double tag_m = 0;
  double gap = 0;  ///< as a share of the tag
  int first_id = 0;

  static auto fields() {
    return std::array{
        BoardField<AprilGrid>{"tag", &AprilGrid::tag_m},
        BoardField<AprilGrid>{.key = "gap", .member = &AprilGrid::gap, .is_share = true},
        BoardField<AprilGrid>{.key = "first_id", .member = &AprilGrid::first_id, .is_optional = true}};
  }
  [[nodiscard]] std::optional<ErrorDetail> fault() const;

  [[nodiscard]] PointLayout layout() const {
    return {.columns = 2 * columns,
            .rows = 2 * rows,
            .spacing_m = tag_m * std::min(1.0, gap),
            .margin_m = gap * tag_m};
  }
  [[nodiscard]] std::optional<MarkerIds> markers() const {
    return MarkerIds{
        .family = std::string(kDictionary), .first = first_id, .last = first_id + columns * rows - 1};
  }
  /// Id of the tag at a column and row, counted from the top left.
  [[nodiscard]] int tagId(int column, int row) const {
    return first_id + (rows - 1 - row) * columns + column;
  }
  /// The left or upper side of the tags of a column or row, metres from the origin.
  [[nodiscard]] double tagPlace(int index) const { return tag_m * (1 + gap) * index; }

  [[nodiscard]] Eigen::Vector3d corner(int id) const {
    const auto place = [this](int i) { return tagPlace(i / 2) + tag_m * (i % 2); };
    return {place(id % (2 * columns)), place(id / (2 * columns)), 0.0};
  }

  friend bool operator==(const AprilGrid&, const AprilGrid&) = default;
};

/// Discs in columns and rows, dark on bright or bright on dark. Columns and rows count discs; ids run along
/// the columns first, and the frame is that of a Checkerboard, with the origin at the centre of disc 0.
struct CircleGrid {
  static constexpr std::string_view kName = "circles";
  static constexpr std::string_view kAliases = "circle_grid circles_grid symmetric_circles";
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
  [[nodiscard]] std::optional<ErrorDetail> fault() const;

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
  static constexpr std::string_view kAliases = "asymmetric_circles asymmetric_circle_grid";
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
  [[nodiscard]] std::optional<ErrorDetail> fault() const;

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
