// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "alidade/report/canvas/figure_canvas.h"
#include "alidade/report/canvas/level_map.h"

namespace alidade {

/// Draws errors over an image, as areas between multiples of the tolerance with contours and their values.
/// @param errors  in px; NaN where there is none
/// @param avoid   places in the drawing from which the values keep away
/// @returns the entries of a legend, of what there is on the map
Legend addToleranceMap(LevelMap errors, double tolerance_px, FigureCanvas& canvas,
                       const std::vector<Eigen::Vector2d>& avoid = {});

/// How its colours relate to the tolerance, in a sentence. @param legend  what addToleranceMap() returned
[[nodiscard]] std::string toleranceSentence(const Legend& legend, double tolerance_px);

}  // namespace alidade
