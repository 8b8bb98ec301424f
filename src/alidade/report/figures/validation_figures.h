// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "alidade/report/canvas/figure_canvas.h"
#include "alidade/report/data/validation_data.h"

namespace alidade {

// Figures of a camera on images that it was not calibrated from.

/// The RMS of each view with the camera as it is, and with the one that the images give, as pairs of bars.
/// Bars carry their view's number as data-view and their value as data-rms. @pre there is a freed camera
[[nodiscard]] Figure fixedFreedFigure(const JudgedCamera& camera);
/// Where the camera that the images give projects distant points, compared with the tested one.
[[nodiscard]] Figure freedDifferenceFigure(const ReportData& data, const Calibration& freed);
/// The parameters with their stated standard deviations and, if images give a camera, its own, as HTML.
[[nodiscard]] std::string judgedParameters(const JudgedCamera& judged, const std::string& prefix);

}  // namespace alidade
