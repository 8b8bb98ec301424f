// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/report/figure_canvas.h"
#include "alidade/report/report_data.h"

namespace alidade {

/// Boards and camera in space, as the camera frame has them. Each shape carries its points in data-points
/// (metres, x y z for each), from which the page's script draws the scene again when it is turned; the file
/// shows it from data-yaw and data-pitch (degrees).
[[nodiscard]] Figure sceneFigure(const ReportData& data);

}  // namespace alidade
