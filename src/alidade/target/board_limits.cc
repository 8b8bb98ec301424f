// SPDX-License-Identifier: MIT
#include "alidade/target/board_limits.h"

#include <algorithm>
#include <string>

#include "alidade/core/text.h"

namespace alidade::detail {

std::optional<BoardFault> countsFault(int columns, int rows, int least, int most, std::string_view what) {
  if (std::min(columns, rows) >= least && std::max(columns, rows) <= most) return std::nullopt;
  return BoardFault{
      .found = std::to_string(columns) + "x" + std::to_string(rows) + " " + std::string(what),
      .expected = "between " + std::to_string(least) + " and " + std::to_string(most) + " in each direction"};
}

std::optional<BoardFault> sideFault(double side_m, std::string_view what) {
  // A board with squares of 0.1 mm is for a microscope, one with squares of 2 m covers the floor of a hangar.
  constexpr double kMinSide = 1e-4;
  constexpr double kMaxSide = 2.0;
  if (side_m >= kMinSide && side_m <= kMaxSide) return std::nullopt;
  BoardFault fault{.found = std::string(what) + " of " + exactText(side_m) + " m",
                   .expected = "between 0.1 mm and 2 m"};
  if (side_m > kMaxSide && side_m <= 1000 * kMaxSide)
    fault.next_step = "a bare number is metres: did you mean " + exactText(side_m) + "mm?";
  return fault;
}

}  // namespace alidade::detail
