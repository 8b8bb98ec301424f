// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/report/canvas/figure_canvas.h"
#include "alidade/report/data/report_data.h"

namespace alidade {

// Figures of the views: errors of each, and poses of the boards.

/// RMS and largest error of each view, in their order. Bars carry their view's index as data-view.
[[nodiscard]] Figure viewErrorsFigure(const ReportData& data);
/// Tilt of the board in each view, and the next one.
[[nodiscard]] Figure tiltFigure(const CalibrationEvidence& data);
/// Distance and tilt of the board in each view, and the next one.
[[nodiscard]] Figure distanceFigure(const CalibrationEvidence& data);
/// The photograph to take next, as seen by the photographer. @pre there is a next view
[[nodiscard]] Figure nextViewFigure(const CalibrationEvidence& data);
/// A small drawing of a view's corners in its image, for views without an image.
[[nodiscard]] std::string cornersPicture(const ReportData& data, const ReportedView& view);

}  // namespace alidade
