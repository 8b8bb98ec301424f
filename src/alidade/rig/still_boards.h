// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "alidade/calibrate/calibrator.h"
#include "alidade/rig/rig_frames.h"

namespace alidade {

/// Of each board, of each frame: the first of those frames that are one for it, as the board stood still.
///
/// A camera that saw a board at the same place in several frames has one view for them all, see
/// mergeRepeatedViews(). Another camera may have seen it in any of these frames. They count as one unless a
/// camera tells two of them apart.
/// @param given  the views that each camera was given
/// @param alone  the cameras calibrated from these
[[nodiscard]] std::vector<std::vector<std::size_t>> firstFrames(const RigFrames& frames,
                                                                std::span<const RigViews> given,
                                                                std::span<const Calibration> alone);

}  // namespace alidade
