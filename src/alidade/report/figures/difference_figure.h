// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/report/canvas/figure_canvas.h"
#include "alidade/report/data/report_data.h"

namespace alidade {

/// Displacement of distant points between the calibrated camera and the other one, after the best rotation.
/// @throws Error (kInput) for a camera with a different image aspect ratio
[[nodiscard]] Figure differenceFigure(const ReportData& data, const RivalCamera& rival);

}  // namespace alidade
