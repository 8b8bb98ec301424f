// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

#include "alidade/adjust/board/fit.h"
#include "alidade/report/data/json_output.h"

// Shapes of boards in documents of one camera and of a rig.

namespace alidade {

/// A single value for the only board of a fit, or a list with one value per board.
template <class ValueOf>
[[nodiscard]] json ofEachBoard(const Fit& fit, const ValueOf& valueOf) {
  if (fit.boards.size() == 1) return valueOf(std::size_t{0});
  json list = json::array();
  for (std::size_t board = 0; board < fit.boards.size(); ++board) list.push_back(valueOf(board));
  return list;
}

/// The bend of a board (m), 0 if it is not estimated, and for an uneven board the offsets of its points, m,
/// in the board's frame. If there are several boards, each has its SPEC and the number of its views.
[[nodiscard]] json fittedShapeJson(const Fit& fit, std::size_t board);

}  // namespace alidade
