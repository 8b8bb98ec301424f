// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "alidade/core/image.h"
#include "alidade/target/checkerboard.h"
#include "alidade/target/view.h"

namespace alidade {

/// What came of looking for a board in an image.
enum class DetectionReason {
  kFound,
  kNoBoard,      ///< nothing of this size in the image
  kLargerBoard,  ///< the pattern goes on beyond the grid that was asked for
  kIrregular,    ///< corners were found, but they do not form a grid after refinement
  kUnreadable,   ///< the image could not be read
  kOtherSize,    ///< the image has another size than most
};

/// Stable name of a reason for files and JSON, such as "no_board".
[[nodiscard]] std::string_view reasonCode(DetectionReason reason);

struct Detection {
  DetectionReason reason = DetectionReason::kNoBoard;
  std::string detail;           ///< one sentence for people; empty when found
  std::vector<Corner> corners;  ///< all corners in order of id, or empty

  [[nodiscard]] bool found() const { return reason == DetectionReason::kFound; }
};

/// The board is searched on copies of the image no longer than these sides, the smaller first. The full image
/// is only used to refine what was found: a search at 12 megapixels would take seconds where no board is.
struct DetectorOptions {
  int first_search_px = 720;
  int last_search_px = 1440;
};

/// Finds the whole checkerboard in a grey image and refines its corners on the full image, in windows tied to
/// the local size of the squares. The order of corners is the same physical one in every view of a board that
/// is not ambiguous (see orderCorners).
[[nodiscard]] Detection detectCheckerboard(const GrayImage& image, const Checkerboard& board,
                                           const DetectorOptions& options = {});

}  // namespace alidade
