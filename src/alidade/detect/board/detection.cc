// SPDX-License-Identifier: MIT
#include "alidade/detect/board/detection.h"

#include <algorithm>
#include <array>

namespace alidade {

std::string_view reasonCode(DetectionReason reason) {
  constexpr std::array<std::string_view, 14> kCodes = {
      "found",          "partial",   "cut",     "no_board",  "unplaced",  "larger_board", "other_board",
      "several_boards", "irregular", "blurred", "too_small", "duplicate", "unreadable",   "other_size"};
  return kCodes[static_cast<std::size_t>(reason)];
}

bool SeenGrid::hasCountsOf(int board_columns, int board_rows) const {
  return columns == std::max(board_columns, board_rows) && rows == std::min(board_columns, board_rows);
}

}  // namespace alidade
