// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "alidade/report/figure_canvas.h"
#include "alidade/report/level_map.h"

namespace alidade {

/// Draws errors over an image, as areas between multiples of the tolerance with contours and their values.
/// @param errors  in px; NaN where there is none
/// @returns the entries of a legend
std::vector<std::pair<std::string, std::string>> addToleranceMap(LevelMap errors, double tolerance_px,
                                                                 const PlotArea& area, FigureCanvas& canvas);

}  // namespace alidade
