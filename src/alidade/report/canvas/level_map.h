// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace alidade {

/// Values on a grid, to be drawn as areas and contours between its points.
struct LevelMap {
  int columns = 0;
  int rows = 0;
  std::vector<double> values;                         ///< row by row; NaN: no value
  std::function<Eigen::Vector2d(int, int)> point_at;  ///< position of a column and row in the drawing
};

/// The area in which the values are at least `level`, as an SVG path. Values are linear along the sides of
/// cells; cells with a NaN are omitted.
[[nodiscard]] std::string areaFrom(const LevelMap& map, double level);

/// Segments of the lines on which the values equal `level`.
using ContourSegment = std::pair<Eigen::Vector2d, Eigen::Vector2d>;
[[nodiscard]] std::vector<ContourSegment> contourAt(const LevelMap& map, double level);
/// The segments as an SVG path.
[[nodiscard]] std::string contourPath(const std::vector<ContourSegment>& segments);

}  // namespace alidade
