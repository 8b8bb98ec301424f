// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "alidade/adjust/fit.h"
#include "alidade/core/cancel.h"
#include "alidade/rig/rig_calibration.h"
#include "alidade/rig/rig_start.h"
#include "alidade/target/board.h"

namespace alidade {

/// The views of a rig's cameras, each calibrated alone, and how they hang together.
struct JointViews {
  std::vector<PosedView> poses;
  std::vector<const FitView*> views;          ///< of the cameras' own fits
  std::vector<double> sigma_px;               ///< of each camera's corners
  std::vector<std::vector<BoardTurn>> turns;  ///< of each board
  RigStart start;

  [[nodiscard]] const BoardTurn& turnOf(std::size_t v) const {
    return turns[poses[v].board][start.turn_of[v]];
  }
};

/// @param cameras  their `alone` lives as long as the result
/// @param frame_of  of each view that each camera was given
[[nodiscard]] JointViews jointViews(std::span<const Board> boards, std::span<const RigCamera> cameras,
                                    const std::vector<std::vector<std::size_t>>& frame_of);

/// The fit of all cameras, solved. View v of it is view v of the JointViews.
struct JointFit {
  Fit fit;
  std::vector<std::size_t> unlinked = {};  ///< views that contradict their frame, ascending
  /// Where the board is by each view alone, its camera being where the fit has it.
  std::vector<SE3> rig_from_board = {};
};

/// Solves all intrinsics, poses and board shapes together. Views whose errors exceed three times the noise
/// contradict the others of their frame: they get a placement of their own.
[[nodiscard]] JointFit jointFit(std::span<const RigCamera> cameras, const JointViews& views,
                                const CancelFlag* cancel);

/// The views of each placement.
[[nodiscard]] std::vector<std::vector<std::size_t>> viewsOfPlacements(const Fit& fit);

}  // namespace alidade
