// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "alidade/calibrate/calibrator.h"
#include "alidade/rig/joint_views.h"
#include "alidade/rig/rig_frames.h"
#include "alidade/target/board.h"

namespace alidade {

/// "left, right | back" for the names of cameras and the part that each is in.
[[nodiscard]] std::string partsText(std::span<const std::string> names, std::span<const std::size_t> part_of);

/// Finds the poses of cameras from frames in which two of them see the same board: the pose on which most of
/// these frames agree, over all turns of ambiguous boards. Cameras that never see a board together are linked
/// through others, or by motion: see linkByMotion().
///
/// A camera that saw a board at the same place in several frames has one view for all of them, see
/// mergeRepeatedViews(). A second camera may have seen it in any of these frames. They count as one unless
/// some camera distinguishes two of them.
/// @param given  the views that each camera was given
/// @param alone  the cameras calibrated from these
[[nodiscard]] JointViews jointViews(std::span<const Board> boards, RigFrames frames,
                                    std::span<const RigViews> given, std::vector<Calibration> alone);

}  // namespace alidade
