// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/target/board.h"
#include "alidade/target/board_ink.h"

namespace alidade {

struct InkOptions {
  bool is_bright_first = false;  ///< of a ChArUco board's two layouts, that with a marker in the first square
  int april_border = 2;          ///< of tags, in cells: Kalibr's boards have 2, others 1
};

/// Checkerboards: squares around all inner corners, in alternating colours; that between the corners of
/// columns and rows 0 and 1 is dark.
[[nodiscard]] BoardInk inkOf(const Board& board, const InkOptions& options = {});

}  // namespace alidade
