// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "alidade/core/image.h"
#include "alidade/target/checkerboard.h"
#include "alidade/target/view.h"

namespace alidade {

/// What came of looking for a board in an image. The first three give corners; the others do not.
enum class DetectionReason {
  kFound,          ///< every corner of the board
  kPartial,        ///< some corners are covered or unclear; those seen have their certain ids
  kCut,            ///< some corners lie outside the image; those seen have their certain ids
  kNoBoard,        ///< no checkerboard pattern in the image
  kUnplaced,       ///< a part of a board, but which part cannot be told
  kLargerBoard,    ///< the pattern has more corners than the board that was asked for
  kOtherBoard,     ///< a whole board of other counts
  kSeveralBoards,  ///< two or more boards that fit: which one is meant cannot be told
  kIrregular,      ///< corners were found, but they do not form a grid after refinement
  kBlurred,        ///< the board is seen, but too blurred to locate its corners
  kTooSmall,       ///< the board is seen, but its squares are too few pixels wide
  kDuplicate,      ///< shows the same as another image
  kUnreadable,     ///< the image could not be read
  kOtherSize,      ///< the image has another size than most
};

/// Stable name of a reason for files and JSON, such as "no_board".
[[nodiscard]] std::string_view reasonCode(DetectionReason reason);

/// True for the reasons that come with corners.
[[nodiscard]] bool givesCorners(DetectionReason reason);

/// The pattern of squares that an image shows, whatever was asked for.
struct SeenGrid {
  int columns = 0;  ///< inner corners along the longer side
  int rows = 0;
  int num_corners = 0;
  bool is_closed = false;  ///< the board's border was seen on all four sides: these are its counts
};

/// How well a board is shown. NaN where nothing was measured.
struct ViewMeasures {
  double blur_px =
      std::numeric_limits<double>::quiet_NaN();  ///< median over corners of the edges' one-sigma blur
  double spacing_px = std::numeric_limits<double>::quiet_NaN();  ///< median distance between neighbours
  double area_share = 0;  ///< of the image's area, covered by squares between corners
  /// Median over corners of the angle at which a square would look like that from far: arccos of the ratio of
  /// the singular values of [step_u step_v]. Without intrinsics, so it is a few degrees off for wide lenses.
  double tilt_deg = std::numeric_limits<double>::quiet_NaN();
};

struct Detection {
  DetectionReason reason = DetectionReason::kNoBoard;
  std::string detail;           ///< one sentence for people; empty when all was found
  std::vector<Corner> corners;  ///< in order of id, each with its sigma; empty unless givesCorners(reason)
  ViewMeasures measures;
  std::optional<SeenGrid> seen;

  [[nodiscard]] bool found() const { return reason == DetectionReason::kFound; }
  [[nodiscard]] bool hasCorners() const { return givesCorners(reason); }
};

/// Finds a checkerboard in a grey image, whole or in part, and refines its corners (fitCorner). The search
/// runs on halved copies of the image; the full one is only used to refine. The order of corners is the same
/// physical one in every view of a board that is not ambiguous: the columns run clockwise of the rows'
/// opposite, as seen, and corner 0 is the one whose inner square is dark. For an ambiguous board, the columns
/// run to the right in the image, or downwards if they do so more.
[[nodiscard]] Detection findBoard(const GrayImage& image, const Checkerboard& board);

}  // namespace alidade
