// SPDX-License-Identifier: MIT
#include "alidade/target/checkerboard.h"

#include "alidade/target/board_limits.h"

namespace alidade {

std::optional<BoardFault> Checkerboard::fault() const {
  if (auto fault = detail::countsFault(columns, rows, 3, 200, kWords.counted)) return fault;
  return detail::sideFault(square_m, "squares");
}

}  // namespace alidade
