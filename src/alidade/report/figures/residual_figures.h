// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

#include "alidade/report/canvas/figure_canvas.h"
#include "alidade/report/data/report_data.h"

namespace alidade {

// Figures of the reprojection errors other than over the image.

/// Apparent displacement of each point on a board, over all views that show it.
/// @param board  index into ReportData::boards
[[nodiscard]] Figure boardResidualsFigure(const ReportData& data, std::size_t board);
/// The distribution of the errors, with the normal curve of the same standard deviation. Bars carry their
/// count as data-count.
[[nodiscard]] Figure histogramFigure(const ReportData& data);
/// Quantiles of the errors over those of the normal distribution.
[[nodiscard]] Figure normalPlotFigure(const ReportData& data);

}  // namespace alidade
