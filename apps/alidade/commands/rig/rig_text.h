// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "alidade/rig/rig_calibration.h"
#include "board_views.h"

namespace alidade {

/// The summary of a rig's calibration for people, in the layout used for a single camera: at most 100
/// columns; the verdict, the worst transfer between cameras and all failures first; at most 16 lines unless
/// cameras and failures need more.
/// @param given  of each camera; the views are not used
/// @param num_frames  with a board that two or more cameras saw
[[nodiscard]] std::string rigSummaryText(const RigCalibration& rig, const std::vector<GivenViews>& given,
                                         int num_frames, bool is_coloured);

/// The details that --verbose adds to the summary.
[[nodiscard]] std::string rigDetailsText(const RigCalibration& rig, const std::vector<GivenViews>& given);

}  // namespace alidade
