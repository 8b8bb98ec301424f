// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "alidade/report/canvas/figure_canvas.h"
#include "alidade/report/data/validation_data.h"

namespace alidade {

// Figures of a camera for images that it was not calibrated from.

/// The RMS of each view with the unchanged camera and with the one calibrated from the images, as pairs of
/// bars. Bars carry their view's number as data-view and their value as data-rms. @pre there is a freed
/// camera
[[nodiscard]] Figure fixedFreedFigure(const JudgedCamera& camera);
/// Displacement of distant points between the tested camera and the one calibrated from the images.
[[nodiscard]] Figure freedDifferenceFigure(const ReportData& data, const Calibration& freed);
/// The parameters with their stated standard deviations and, if available, those calibrated from the images,
/// as HTML.
[[nodiscard]] std::string judgedParameters(const JudgedCamera& judged, const std::string& prefix);

}  // namespace alidade
