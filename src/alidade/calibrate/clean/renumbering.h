// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "alidade/adjust/board/fit.h"
#include "alidade/target/board.h"
#include "alidade/target/view.h"

namespace alidade {

/// A view's corners under a different numbering.
struct Renumbering {
  std::string how;  ///< "column by column instead of row by row"
  View view;
};

/// Mistakes in numbering a board that no pose compensates for. Numbering from a different end, turned or
/// mirrored, is not included because a pose compensates for it.
[[nodiscard]] std::vector<Renumbering> renumberings(const Board& board, const View& view);

/// The numbering with which all corners of a view fit the camera; nothing if none helps.
[[nodiscard]] std::optional<std::string> fittingOrder(const Fit& fit, const View& view);

}  // namespace alidade
