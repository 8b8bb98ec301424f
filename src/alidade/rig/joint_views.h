// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "alidade/adjust/board/fit.h"
#include "alidade/calibrate/calibrator.h"
#include "alidade/geometry/se3.h"
#include "alidade/rig/pair_link.h"
#include "alidade/rig/rig_calibration.h"
#include "alidade/rig/rig_frames.h"

namespace alidade {

/// A view of a board by one camera of a rig that was calibrated alone.
struct PosedView {
  std::size_t camera = 0;
  std::size_t frame = 0;
  std::size_t board = 0;
  SE3 camera_from_board = {};
  const FitView* view = nullptr;  ///< of the camera's own fit
};

/// Parts of a rig that could be linked by motion if boards turned about a second axis.
struct LittleMotion {
  std::size_t first = 0;  ///< a camera of each part
  std::size_t second = 0;
  RigTurns turns = {};  ///< in the frame of `second`
};

/// The views of a rig's cameras, each calibrated alone, with the poses of the cameras and the numbering of
/// ambiguous boards.
struct JointViews {
  std::vector<Calibration> alone;  ///< of each camera
  std::vector<PosedView> poses;
  RigFrames frames;
  std::vector<double> sigma_px;  ///< of each camera's corners
  std::vector<LinkBoard> boards;
  std::vector<std::size_t> part_of;  ///< of each camera; cameras of one part are linked
  std::size_t num_parts = 0;
  std::vector<SE3> camera_from_rig;  ///< of each camera; a part's first camera is at the origin
  /// For each board: the first board of its body, and its place in it. See linkByMotion().
  std::vector<std::size_t> body_of;
  std::vector<SE3> body_from_board;
  std::vector<std::size_t> common_part_of;  ///< the part of each camera by common boards, if bodies link some
  std::optional<LittleMotion> little_motion;
  std::vector<std::size_t> turn_of;  ///< of each view, an index into boardTurns() of its board
  std::vector<bool> agrees;          ///< of each view: its pose matches those of its frame
  /// The time of each camera minus that of the first one of its part at one instant, in intervals between
  /// frames, as the motion of the boards shows.
  std::vector<double> lags;
  std::vector<bool> are_mirrored;  ///< of each camera: its images, or those of the first one of its part

  [[nodiscard]] const BoardTurn& turnOf(std::size_t v) const {
    return boards[poses[v].board].turns[turn_of[v]];
  }
  /// The pose of its body by a view alone, if its board is turned like this.
  [[nodiscard]] SE3 rigFromBody(std::size_t v, const BoardTurn& turn) const {
    const PosedView& pose = poses[v];
    return camera_from_rig[pose.camera].inverse() * pose.camera_from_board *
           (body_from_board[pose.board] * turn.turned_from_board).inverse();
  }
};

}  // namespace alidade
