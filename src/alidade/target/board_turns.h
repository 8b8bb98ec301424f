// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "alidade/geometry/se3.h"
#include "alidade/target/board.h"

namespace alidade {

/// A turn of a board about its normal after which it looks the same.
struct BoardTurn {
  SE3 turned_from_board = {};   ///< maps a point of the board to the point that looks the same
  std::vector<int> id_of = {};  ///< of each corner, the id of its equivalent after the turn
};

/// True if the camera is on the printed side of a board. From behind, one that is printed through looks
/// mirrored.
[[nodiscard]] inline bool seesPrintedSide(const SE3& camera_from_board) {
  return camera_from_board.inverse().translation.z() < 0;
}

/// The turns after which a board looks the same, by growing angle; the first is the identity.
[[nodiscard]] std::vector<BoardTurn> boardTurns(const Board& board);

}  // namespace alidade
