// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "alidade/rig/rig_calibration.h"
#include "alidade/rig/rig_frames.h"

namespace alidade {

/// The frames of views, in which several during which a board stood still are one.
///
/// A camera that saw a board at the same place in several frames has one view for them all, see
/// mergeRepeatedViews(). Another camera may have seen it in any of these frames. They count as one unless a
/// camera tells two of them apart.
class FramesOfBoards {
 public:
  /// @param given    the views that each camera was given
  /// @param cameras  calibrated alone from these
  FramesOfBoards(const RigFrames& frames, std::span<const RigViews> given,
                 std::span<const RigCamera> cameras);

  /// The frame of a view that a camera was given: the first of those that are one.
  [[nodiscard]] std::size_t of(std::size_t camera, std::size_t source, std::size_t board) const {
    return first_of_[board][frame_of_[camera][source]];
  }

 private:
  std::vector<std::vector<std::size_t>> frame_of_;
  std::vector<std::vector<std::size_t>> first_of_;  // of each board, of each frame
};

}  // namespace alidade
