// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/report/canvas/figure_canvas.h"
#include "alidade/report/data/report_data.h"

namespace alidade {

// Figures over the image of the camera.

/// The 95 % error of a projected point, as areas between multiples of the tolerance, with contours.
/// @pre there is an accuracy
/// @param is_by_covariance  computed only from the covariance in a camera file
[[nodiscard]] Figure accuracyFigure(const ReportData& data, bool is_by_covariance = false);
/// The used corners, and their number in each cell of the image.
[[nodiscard]] Figure coverageFigure(const CalibrationEvidence& data);
/// Reprojection errors as arrows: a sample of single corners, and the mean and RMS in each cell. Cells carry
/// their RMS and their count as data-rms and data-count.
[[nodiscard]] Figure imageResidualsFigure(const ReportData& data);

}  // namespace alidade
