// SPDX-License-Identifier: MIT
#include "alidade/target/april_grid.h"

#include "alidade/core/text.h"
#include "alidade/target/board_limits.h"
#include "alidade/target/charuco_board.h"

namespace alidade {

std::optional<BoardFault> AprilGrid::fault() const {
  if (auto fault = detail::countsFault(columns, rows, 1, 24, kWords.counted)) return fault;
  const int count = columns * rows;
  if (count < 2) return BoardFault{.found = "1x1 tags", .expected = "2 tags or more"};
  if (auto fault = detail::sideFault(tag_m, kWords.counted)) return fault;
  if (!(gap >= 0.1 && gap <= 1)) {
    return BoardFault{.found = "gaps of " + exactText(gap) + " tags", .expected = "between 0.1 and 1"};
  }
  const int most = findMarkerDictionary(kDictionary)->num_markers;
  if (first_id >= 0 && first_id <= most - count) return std::nullopt;
  return BoardFault{
      .found = std::to_string(count) + " tags from id " + std::to_string(first_id) + " to " +
               std::to_string(static_cast<long long>(first_id) + count - 1),
      .expected = "ids from 0 to " + std::to_string(most - 1) + ", which the family 36h11 has",
      .next_step = first_id < 0 ? "" : "the first id may be " + std::to_string(most - count) + " at most"};
}

}  // namespace alidade
