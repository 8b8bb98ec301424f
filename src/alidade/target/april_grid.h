// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <string_view>

#include <Eigen/Core>

#include "alidade/target/board_field.h"

namespace alidade {

/// Kalibr's grid of AprilTags of the family 36h11. Columns and rows count tags. Tag ids start at the bottom
/// left of the print and run to the right, then upwards; small squares fill the gaps between tags. Its points
/// are the outer corners of the tags, 2 columns x 2 rows of them; the frame is that of a Checkerboard, with
/// the origin at the top left.
struct AprilGrid {
  static constexpr std::string_view kName = "aprilgrid";
  static constexpr std::string_view kExample =
      "aprilgrid:6x6:88mm:0.3 (columns x rows of tags, the side of a tag, the gap as a share of it)";
  static constexpr BoardWords kWords = {.counted = "tags",
                                        .points = "tag corners",
                                        .marker = "tag",
                                        .other_markers = "another first id (the last part of the SPEC)"};
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
  [[nodiscard]] std::optional<BoardFault> fault() const;

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

}  // namespace alidade
