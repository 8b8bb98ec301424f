// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/target/board.h"
#include "alidade/target/board_ink.h"

namespace alidade {

struct InkOptions {
  bool is_bright_first = false;  ///< a ChArUco board whose first square is bright and holds a marker
  int april_border = 2;          ///< border of tags, in cells: 2 on Kalibr's boards, otherwise 1
};

/// Checkerboards: squares around all inner corners, in alternating colours; the one between the corners of
/// columns and rows 0 and 1 is dark.
[[nodiscard]] BoardInk inkOf(const Board& board, const InkOptions& options = {});

}  // namespace alidade
