// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "alidade/report/canvas/figure_canvas.h"
#include "alidade/report/data/rig_data.h"

namespace alidade {

/// The cameras of a rig and the observed boards, in the rig's frame.
[[nodiscard]] Figure rigSceneFigure(const ReportedRig& rig);
/// RMS distance from epipolar lines for each two cameras. Bars carry it as data-rms. @pre at least one pair
[[nodiscard]] Figure epipolarFigure(const ReportedRig& rig, const std::vector<EpipolarPair>& pairs);
/// The same frame by frame. @pre at least one pair
[[nodiscard]] Figure epipolarOverTimeFigure(const ReportedRig& rig, const std::vector<EpipolarPair>& pairs);
/// RMS of each image, a row per camera and a column per frame. Cells carry it as data-rms.
[[nodiscard]] Figure frameErrorsFigure(const ReportedRig& rig);

}  // namespace alidade
