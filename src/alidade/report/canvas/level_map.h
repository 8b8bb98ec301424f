// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "alidade/report/canvas/figure_canvas.h"

namespace alidade {

/// Values on a grid, to be drawn as areas and contours between its points.
struct LevelMap {
  int columns = 0;
  int rows = 0;
  std::vector<double> values = {};           ///< row by row; NaN: no value
  std::vector<Eigen::Vector2d> points = {};  ///< their positions in the drawing
};

/// The area in which the values are at least `level`, as an SVG path. Values are linear along the sides of
/// cells; cells with a NaN are omitted.
[[nodiscard]] std::string areaFrom(const LevelMap& map, double level);

/// Segments of the lines on which the values equal `level`.
using ContourSegment = std::pair<Eigen::Vector2d, Eigen::Vector2d>;
[[nodiscard]] std::vector<ContourSegment> contourAt(const LevelMap& map, double level);
/// The segments as an SVG path.
[[nodiscard]] std::string contourPath(const std::vector<ContourSegment>& segments);

/// Draws errors over an image, as areas between multiples of the tolerance with contours and their values.
/// @param errors  in px; NaN if unknown
/// @param avoid   places in the drawing where no label goes
/// @returns the legend entries for the levels on the map
Legend addToleranceMap(LevelMap errors, double tolerance_px, FigureCanvas& canvas,
                       const std::vector<Eigen::Vector2d>& avoid = {});

/// A sentence on the relation between colours and tolerance. @param legend  result of addToleranceMap()
[[nodiscard]] std::string toleranceSentence(const Legend& legend, double tolerance_px);

}  // namespace alidade
