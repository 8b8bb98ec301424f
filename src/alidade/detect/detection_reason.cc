// SPDX-License-Identifier: MIT
#include "alidade/detect/checkerboard_detector.h"

namespace alidade {

std::string_view reasonCode(DetectionReason reason) {
  switch (reason) {
    case DetectionReason::kFound:
      return "found";
    case DetectionReason::kPartial:
      return "partial";
    case DetectionReason::kCut:
      return "cut";
    case DetectionReason::kNoBoard:
      return "no_board";
    case DetectionReason::kUnplaced:
      return "unplaced";
    case DetectionReason::kLargerBoard:
      return "larger_board";
    case DetectionReason::kOtherBoard:
      return "other_board";
    case DetectionReason::kSeveralBoards:
      return "several_boards";
    case DetectionReason::kIrregular:
      return "irregular";
    case DetectionReason::kBlurred:
      return "blurred";
    case DetectionReason::kTooSmall:
      return "too_small";
    case DetectionReason::kDuplicate:
      return "duplicate";
    case DetectionReason::kUnreadable:
      return "unreadable";
    case DetectionReason::kOtherSize:
      return "other_size";
  }
  return "unknown";
}

bool givesCorners(DetectionReason reason) {
  return reason == DetectionReason::kFound || reason == DetectionReason::kPartial ||
         reason == DetectionReason::kCut;
}

}  // namespace alidade
