// SPDX-License-Identifier: MIT
#include "alidade/target/board_turns.h"

#include <algorithm>
#include <numbers>
#include <utility>

namespace alidade {

std::vector<BoardTurn> boardTurns(const Board& board) {
  std::vector<BoardTurn> turns;
  for (int quarters = 0; quarters < 4; quarters += board.symmetryStep()) {
    BoardTurn turn;
    const double angle = quarters * std::numbers::pi / 2;
    turn.turned_from_board.rotation = SO3::exp(Eigen::Vector3d(0, 0, angle));
    turn.turned_from_board.translation = board.middle() - turn.turned_from_board.rotation * board.middle();
    for (const Eigen::Vector3d& corner : board.corners()) {
      const Eigen::Vector3d turned = turn.turned_from_board * corner;
      const auto same = std::ranges::min_element(
          board.corners(), {}, [&](const Eigen::Vector3d& other) { return (other - turned).squaredNorm(); });
      turn.id_of.push_back(static_cast<int>(same - board.corners().begin()));
    }
    turns.push_back(std::move(turn));
  }
  return turns;
}

}  // namespace alidade
