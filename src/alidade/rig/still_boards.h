// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "alidade/calibrate/calibrator.h"
#include "alidade/rig/rig_frames.h"

namespace alidade {

/// For each board and frame: the first of the frames that count as one because the board did not move.
///
/// A camera that saw a board at the same place in several frames has one view for all of them, see
/// mergeRepeatedViews(). A second camera may have seen it in any of these frames. They count as one unless
/// some camera distinguishes two of them.
/// @param given  the views that each camera was given
/// @param alone  the cameras calibrated from these
[[nodiscard]] std::vector<std::vector<std::size_t>> firstFrames(const RigFrames& frames,
                                                                std::span<const RigViews> given,
                                                                std::span<const Calibration> alone);

}  // namespace alidade
