// SPDX-License-Identifier: MIT
#include "alidade/report/canvas/level_map.h"

#include <array>
#include <cmath>
#include <cstddef>

#include "alidade/report/canvas/figure_canvas.h"

namespace alidade {
namespace {

using Eigen::Vector2d;

struct MapCorner {
  Vector2d at;
  double value = 0;
};

// Corners of a cell, clockwise from its upper left.
std::array<MapCorner, 4> cornersOf(const LevelMap& map, int column, int row) {
  std::array<MapCorner, 4> corners;
  constexpr std::array<std::pair<int, int>, 4> kAround = {{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
  for (std::size_t i = 0; i < 4; ++i) {
    const int x = column + kAround[i].first;
    const int y = row + kAround[i].second;
    corners[i] = {.at = map.point_at(x, y),
                  .value = map.values[static_cast<std::size_t>(y * map.columns + x)]};
  }
  return corners;
}

// The point on a side of a cell at which the value equals the level.
Vector2d crossing(const MapCorner& a, const MapCorner& b, double level) {
  return a.at + (level - a.value) / (b.value - a.value) * (b.at - a.at);
}

// A path of small shapes, with relative steps, because maps have thousands of points.
std::string shapePath(const std::vector<Vector2d>& points, bool is_closed) {
  std::string d;
  Vector2d last(0, 0);
  for (const Vector2d& point : points) {
    const Vector2d step = point - last;
    if (!d.empty() && step.norm() < 0.01) continue;
    d += (d.empty()                ? "M"
          : last == points.front() ? "l"
                                   : " ") +
         coordinate(step.x()) + "," + coordinate(step.y());
    last = point;
  }
  return is_closed ? d + "Z" : d;
}

enum class CellKind { kOut, kIn, kMixed };

CellKind kindOf(const std::array<MapCorner, 4>& corners, double level) {
  int num_in = 0;
  for (const MapCorner& corner : corners) {
    if (std::isnan(corner.value)) return CellKind::kOut;
    num_in += corner.value >= level ? 1 : 0;
  }
  return num_in == 0 ? CellKind::kOut : num_in == 4 ? CellKind::kIn : CellKind::kMixed;
}

std::string mixedCell(const std::array<MapCorner, 4>& corners, double level) {
  std::vector<Vector2d> outline;
  for (std::size_t i = 0; i < 4; ++i) {
    const MapCorner& a = corners[i];
    const MapCorner& b = corners[(i + 1) % 4];
    if (a.value >= level) outline.push_back(a.at);
    if ((a.value >= level) != (b.value >= level)) outline.push_back(crossing(a, b, level));
  }
  return shapePath(outline, true);
}

}  // namespace

std::string areaFrom(const LevelMap& map, double level) {
  std::string d;
  for (int row = 0; row + 1 < map.rows; ++row) {
    int first = -1;  // start of a run of whole cells, which become one rectangle
    const auto closeRun = [&](int end) {
      if (first < 0) return;
      d += shapePath({map.point_at(first, row), map.point_at(end, row), map.point_at(end, row + 1),
                      map.point_at(first, row + 1)},
                     true);
      first = -1;
    };
    for (int column = 0; column + 1 < map.columns; ++column) {
      const auto corners = cornersOf(map, column, row);
      const CellKind kind = kindOf(corners, level);
      if (kind != CellKind::kIn) closeRun(column);
      if (kind == CellKind::kIn && first < 0) first = column;
      if (kind == CellKind::kMixed) d += mixedCell(corners, level);
    }
    closeRun(map.columns - 1);
  }
  return d;
}

std::vector<ContourSegment> contourAt(const LevelMap& map, double level) {
  std::vector<ContourSegment> segments;
  for (int row = 0; row + 1 < map.rows; ++row) {
    for (int column = 0; column + 1 < map.columns; ++column) {
      const auto corners = cornersOf(map, column, row);
      if (kindOf(corners, level) != CellKind::kMixed) continue;
      std::vector<Vector2d> crossings;
      for (std::size_t i = 0; i < 4; ++i) {
        const MapCorner& a = corners[i];
        const MapCorner& b = corners[(i + 1) % 4];
        if ((a.value >= level) != (b.value >= level)) crossings.push_back(crossing(a, b, level));
      }
      for (std::size_t i = 0; i + 1 < crossings.size(); i += 2)
        segments.emplace_back(crossings[i], crossings[i + 1]);
    }
  }
  return segments;
}

std::string contourPath(const std::vector<ContourSegment>& segments) {
  std::string d;
  for (const auto& [from, to] : segments) d += shapePath({from, to}, false);
  return d;
}

}  // namespace alidade
