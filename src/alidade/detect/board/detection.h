// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "alidade/core/image.h"
#include "alidade/target/board.h"
#include "alidade/target/view.h"

namespace alidade {

/// The outcome of the search for a board in an image. Only the first three yield corners.
enum class DetectionReason {
  kFound,          ///< every corner of the board
  kPartial,        ///< some corners are covered or unclear; the ids of the others are certain
  kCut,            ///< some corners lie outside the image; the ids of the others are certain
  kNoBoard,        ///< no checkerboard pattern in the image
  kUnplaced,       ///< a part of a board, but it is ambiguous which part
  kLargerBoard,    ///< the pattern has more corners than the expected board
  kOtherBoard,     ///< a whole board with different numbers of corners
  kSeveralBoards,  ///< two or more boards match
  kIrregular,      ///< corners were found, but they do not form a grid after refinement
  kBlurred,        ///< the board is visible, but too blurred to locate its corners
  kTooSmall,       ///< the board is visible, but its squares are too small
  kDuplicate,      ///< the same corners as an earlier image
  kUnreadable,     ///< the image could not be read
  kOtherSize,      ///< the image size differs from that of most images
};

/// Stable name of a reason for files and JSON, such as "no_board".
[[nodiscard]] std::string_view reasonCode(DetectionReason reason);

/// The pattern of squares in an image, which may differ from the expected board.
struct SeenGrid {
  int columns = 0;  ///< inner corners along the longer side
  int rows = 0;
  int num_corners = 0;
  bool is_closed = false;  ///< the border of the board is visible on all sides, so the counts are exact

  /// Compares the counts in both orders of columns and rows.
  [[nodiscard]] bool hasCountsOf(int board_columns, int board_rows) const;
};

/// Quality of the view of a board. NaN if not measured.
struct ViewMeasures {
  double blur_px =
      std::numeric_limits<double>::quiet_NaN();  ///< median over corners of the edge blur (sigma)
  double spacing_px = std::numeric_limits<double>::quiet_NaN();  ///< median distance between neighbours
  double area_share = 0;  ///< share of the image that is covered by squares between corners
  /// Median over corners of the tilt of a square, as in a distant view: arccos of the ratio of the singular
  /// values of [step_u step_v]. It uses no intrinsics, so it has an error of a few degrees for wide lenses.
  double tilt_deg = std::numeric_limits<double>::quiet_NaN();
};

/// The measures of a view: medians over its corners; tilts in radians.
/// @param area_px  area of the squares between the corners
[[nodiscard]] ViewMeasures medianMeasures(std::vector<double> blurs, std::vector<double> spacings,
                                          std::vector<double> tilts, double area_px, const ImageSize& size);

struct Detection {
  DetectionReason reason = DetectionReason::kNoBoard;
  std::string detail = {};           ///< one sentence for the user; empty if all corners were found
  std::vector<Corner> corners = {};  ///< in order of id, each with its sigma; empty unless hasCorners()
  ViewMeasures measures = {};
  std::optional<SeenGrid> seen = std::nullopt;

  [[nodiscard]] bool found() const { return reason == DetectionReason::kFound; }
  [[nodiscard]] bool hasCorners() const { return reason <= DetectionReason::kCut; }

  /// Removes the corners, if any, and sets the reason.
  Detection& withdraw(DetectionReason why, std::string sentence);
  /// Sets the reason and a sentence: how many of all corners were found, and what hides the others.
  /// @param points   the word for the board's corners
  /// @param missing  expected places of some of the others, in the image or outside
  void describeMissing(int num_all, std::string_view points, std::span<const Eigen::Vector2d> missing,
                       const ImageSize& size);
};

/// The outcome for one image and one board.
struct ImageOutcome {
  std::string image = {};
  ImageSize size = {};
  int exif_orientation = 1;
  Detection detection = {};
  std::optional<std::size_t> sequence = std::nullopt;  ///< ImageSet::sequenceOf()

  [[nodiscard]] bool isReadable() const { return detection.reason != DetectionReason::kUnreadable; }
};

}  // namespace alidade
