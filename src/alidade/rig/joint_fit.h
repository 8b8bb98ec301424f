// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "alidade/adjust/board/fit.h"
#include "alidade/calibrate/calibrator.h"
#include "alidade/core/cancel.h"
#include "alidade/rig/rig_frames.h"
#include "alidade/rig/rig_start.h"
#include "alidade/target/board.h"

namespace alidade {

/// The views of a rig's cameras, each calibrated alone, and the links between them.
struct JointViews {
  std::vector<Calibration> alone;  ///< of each camera
  std::vector<PosedView> poses;
  std::vector<const FitView*> views;          ///< of `alone`
  std::vector<double> sigma_px;               ///< of each camera's corners
  std::vector<std::vector<BoardTurn>> turns;  ///< of each board
  RigStart start;

  [[nodiscard]] const BoardTurn& turnOf(std::size_t v) const {
    return turns[poses[v].board][start.turn_of[v]];
  }
};

/// @param given  the views that each camera was given
/// @param alone  the cameras calibrated from these
[[nodiscard]] JointViews jointViews(std::span<const Board> boards, const RigFrames& frames,
                                    std::span<const RigViews> given, std::vector<Calibration> alone);

/// The boards that are uneven in any of these fits; all fits have the same boards.
[[nodiscard]] std::vector<std::size_t> unevenBoards(std::span<const Fit* const> fits);

/// The fit of all cameras, solved. View v of it is view v of the JointViews.
struct JointFit {
  Fit fit;
  std::vector<std::size_t> unlinked = {};  ///< views that contradict their frame, ascending
  /// Pose of the board from each view alone, with the camera at its pose in the fit.
  std::vector<SE3> rig_from_board = {};
  bool are_points_lost = false;  ///< no point positions of uneven boards fit all cameras
};

/// Solves all intrinsics, poses and board shapes together. Views whose errors exceed three times the noise
/// contradict the others of their frame and get their own placement.
/// @param uneven  boards whose point positions are estimated
[[nodiscard]] JointFit jointFit(const JointViews& views, std::span<const std::size_t> uneven,
                                const CancelFlag* cancel);

/// sqrt(mean of dx^2 + dy^2) over the corners of a camera, px; NaN without one.
[[nodiscard]] double rmsOfCamera(const Fit& fit, std::size_t camera);

/// The views of each placement.
[[nodiscard]] std::vector<std::vector<std::size_t>> viewsOfPlacements(const Fit& fit);

}  // namespace alidade
