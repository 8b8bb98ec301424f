// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>

#include "alidade/compare/projection_difference.h"
#include "alidade/report/canvas/figure_canvas.h"

namespace alidade {

/// A drawing of the difference of two cameras over the image of the first: its length as colours, an
/// arrow from the pixel of a point in a to that in b, a mark at the largest one, hatching for pixels that
/// cannot be compared, and a scale.
/// @param difference  over a grid, after alignment
/// @param lines       of text below the drawing
[[nodiscard]] Figure differenceDrawing(const ComparedCamera& a, const ComparedCamera& b,
                                       const ProjectionDifference& difference,
                                       std::span<const std::string> lines);

/// The same as a file (SVG).
[[nodiscard]] std::string differenceSvg(const ComparedCamera& a, const ComparedCamera& b,
                                        const ProjectionDifference& difference,
                                        std::span<const std::string> lines);

}  // namespace alidade
