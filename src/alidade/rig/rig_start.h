// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "alidade/adjust/board/fit.h"
#include "alidade/calibrate/calibrator.h"
#include "alidade/geometry/se3.h"
#include "alidade/rig/pair_link.h"
#include "alidade/rig/rig_frames.h"
#include "alidade/target/board.h"

namespace alidade {

/// A view of a board by one camera of a rig that was calibrated alone.
struct PosedView {
  std::size_t camera = 0;
  std::size_t frame = 0;
  std::size_t board = 0;
  SE3 camera_from_board = {};
  const FitView* view = nullptr;  ///< of the camera's own fit
};

/// The views of a rig's cameras, each calibrated alone, with the poses of the cameras and the numbering of
/// ambiguous boards.
struct JointViews {
  std::vector<Calibration> alone;  ///< of each camera
  std::vector<PosedView> poses;
  RigFrames frames;
  std::vector<double> sigma_px;  ///< of each camera's corners
  std::vector<LinkBoard> boards;
  std::vector<std::size_t> part_of;  ///< of each camera; cameras of one part are linked by common boards
  std::size_t num_parts = 0;
  std::vector<SE3> camera_from_rig;  ///< of each camera; a part's first camera is at the origin
  std::vector<std::size_t> turn_of;  ///< of each view, an index into boardTurns() of its board
  std::vector<bool> agrees;          ///< of each view: its pose matches those of its frame
  /// The time of each camera minus that of the first one of its part at one instant, in intervals between
  /// frames, as the motion of the boards shows.
  std::vector<double> lags;
  std::vector<bool> are_mirrored;  ///< of each camera: its images, or those of the first one of its part

  [[nodiscard]] const BoardTurn& turnOf(std::size_t v) const {
    return boards[poses[v].board].turns[turn_of[v]];
  }
};

/// "left, right | back" for the names of cameras and the part that each is in.
[[nodiscard]] std::string partsText(std::span<const std::string> names, std::span<const std::size_t> part_of);

/// Finds the poses of cameras from frames in which two of them see the same board: the pose on which most of
/// these frames agree, over all turns of ambiguous boards. Cameras that never see a board together are linked
/// through others.
///
/// A camera that saw a board at the same place in several frames has one view for all of them, see
/// mergeRepeatedViews(). A second camera may have seen it in any of these frames. They count as one unless
/// some camera distinguishes two of them.
/// @param given  the views that each camera was given
/// @param alone  the cameras calibrated from these
[[nodiscard]] JointViews jointViews(std::span<const Board> boards, RigFrames frames,
                                    std::span<const RigViews> given, std::vector<Calibration> alone);

}  // namespace alidade
