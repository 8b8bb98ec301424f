// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/report/canvas/figure_canvas.h"
#include "alidade/report/data/report_data.h"

namespace alidade {

// Figures of the lens.

/// The images of straight lines of the scene, over those of a pinhole camera.
[[nodiscard]] Figure distortionGridFigure(const ReportData& data);
/// Distance from the principal point over the angle from the optical axis, with the end of the model's domain
/// and that of the range covered by boards.
[[nodiscard]] Figure radialFigure(const ReportData& data);
/// The correlations of the estimated parameters. @pre there is a covariance
[[nodiscard]] Figure correlationFigure(const ReportData& data);

}  // namespace alidade
