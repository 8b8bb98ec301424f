// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>

#include "alidade/report/canvas/figure_canvas.h"
#include "alidade/report/data/report_data.h"
#include "alidade/report/figures/page_pictures.h"

namespace alidade {

/// The image of the view with the largest board, without distortion, with straight lines through the rows and
/// columns of the board. Nothing without an image.
[[nodiscard]] std::optional<Figure> undistortedFigure(const ReportData& data, const ImageOfView& image_of);

/// The name of the image that the figure shows; empty without views.
[[nodiscard]] std::string undistortedImageName(const ReportData& data);

}  // namespace alidade
