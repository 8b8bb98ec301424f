// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "alidade/report/canvas/figure_canvas.h"
#include "alidade/report/canvas/level_map.h"

namespace alidade {

/// Draws errors over an image, as areas between multiples of the tolerance with contours and their values.
/// @param errors  in px; NaN if unknown
/// @param avoid   places in the drawing where no label goes
/// @returns the legend entries for the levels on the map
Legend addToleranceMap(LevelMap errors, double tolerance_px, const PlotArea& area, FigureCanvas& canvas,
                       const std::vector<Eigen::Vector2d>& avoid = {});

/// A sentence on the relation between colours and tolerance. @param legend  result of addToleranceMap()
[[nodiscard]] std::string toleranceSentence(const Legend& legend, double tolerance_px);

}  // namespace alidade
