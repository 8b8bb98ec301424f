// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "alidade/geometry/se3.h"
#include "alidade/target/board.h"
#include "alidade/target/board_turns.h"

namespace alidade {

/// A difference of poses.
struct PoseDistance {
  double rotation_rad = 0;
  double translation = 0;  ///< m; in a limit, a share of the distance to the board

  [[nodiscard]] bool isWithin(const PoseDistance& limit, double distance_m) const {
    return rotation_rad < limit.rotation_rad && translation < limit.translation * distance_m;
  }
  /// The rotation plus the translation as a share of the distance.
  [[nodiscard]] double cost(double distance_m) const { return rotation_rad + translation / distance_m; }
};
[[nodiscard]] PoseDistance between(const SE3& a, const SE3& b);

/// Largest difference of poses that count as the same: single views are rough, grazing ones very rough.
inline constexpr PoseDistance kSamePose = {0.05, 0.05};

/// A board and the ways in which it looks the same.
struct LinkBoard {
  explicit LinkBoard(const Board& of) : board(of), turns(boardTurns(of)) {}
  Board board;
  std::vector<BoardTurn> turns;
};

/// A board as two cameras see it at one time.
struct SharedBoard {
  SE3 a_from_board = {};
  SE3 b_from_board = {};
  std::size_t board = 0;
};

/// The poses of one board before a camera, by whole times in intervals between frames, ascending.
using Track = std::vector<std::pair<std::int64_t, SE3>>;
using Tracks = std::map<std::size_t, Track>;  ///< by board

/// The pose of one camera of a rig relative to another, on which most frames agree.
struct PairLink {
  SE3 b_from_a = {};
  std::size_t num_frames = 0;  ///< that agree
  double lag = 0;              ///< time of b minus that of a at one instant, in intervals between frames
  bool is_mirrored = false;    ///< frames agree only if the images of one of the two are mirrored
};

/// Finds the relative pose of two cameras over all turns of ambiguous boards. If most poses agree at another
/// lag than 0, clearly better than at all others, the recordings started at different times.
/// @param views  with equal times
/// @param a, b   for other lags; may be empty
/// @returns nothing if no board is common
[[nodiscard]] std::optional<PairLink> linkOf(const std::vector<SharedBoard>& views, const Tracks& a,
                                             const Tracks& b, std::span<const LinkBoard> boards);

}  // namespace alidade
