// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "alidade/adjust/board/fit.h"
#include "alidade/target/board.h"
#include "alidade/target/view.h"

namespace alidade {

/// A view's corners as they would be if they had been numbered otherwise.
struct Renumbering {
  std::string how;  ///< "column by column instead of row by row"
  View view;
};

/// The mistakes in numbering a board that no pose makes up for. Numbering from another end, turned or
/// mirrored, is not among them: a pose makes up for it.
[[nodiscard]] std::vector<Renumbering> renumberings(const Board& board, const View& view);

/// How a view's corners must be numbered for all of them to fit the fit's camera; nothing if that does not
/// help.
[[nodiscard]] std::optional<std::string> fittingOrder(const Fit& fit, const View& view);

}  // namespace alidade
