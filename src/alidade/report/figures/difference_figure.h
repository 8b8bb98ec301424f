// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/report/canvas/figure_canvas.h"
#include "alidade/report/data/report_data.h"

namespace alidade {

/// Where the other camera projects distant points after the best rotation, compared with the calibrated one.
/// @throws Error (kInput) for a camera whose image has another shape
[[nodiscard]] Figure differenceFigure(const ReportData& data, const RivalCamera& rival);

}  // namespace alidade
