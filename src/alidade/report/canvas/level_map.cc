// SPDX-License-Identifier: MIT
#include "alidade/report/canvas/level_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include <fmt/format.h>

namespace alidade {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Corners of a cell, clockwise from its upper left: points with their values as z.
using MapCell = std::array<Vector3d, 4>;

MapCell cellAt(const LevelMap& map, int column, int row) {
  constexpr std::array<std::pair<int, int>, 4> kAround = {{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
  MapCell cell;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto at =
        static_cast<std::size_t>((row + kAround[i].second) * map.columns + column + kAround[i].first);
    cell[i] << map.points[at], map.values[at];
  }
  return cell;
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

// Number of corners that reach the level; 0 if one has no value.
std::ptrdiff_t numWithin(const MapCell& cell, double level) {
  if (std::ranges::any_of(cell, [](const Vector3d& corner) { return std::isnan(corner.z()); })) return 0;
  return std::ranges::count_if(cell, [&](const Vector3d& corner) { return corner.z() >= level; });
}

// Points at which the sides cross the level and, with `has_corners`, corners that reach it, in order around
// the cell.
std::vector<Vector2d> crossings(const MapCell& cell, double level, bool has_corners) {
  std::vector<Vector2d> points;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vector3d& a = cell[i];
    const Vector3d& b = cell[(i + 1) % 4];
    if (has_corners && a.z() >= level) points.emplace_back(a.head<2>());
    if ((a.z() >= level) != (b.z() >= level))
      points.emplace_back(a.head<2>() + (level - a.z()) / (b.z() - a.z()) * (b - a).head<2>());
  }
  return points;
}

// Multiples of the tolerance at which a colour of the map ends; the colour after the last one has no end.
constexpr std::array<double, 6> kMapLevels = {0.25, 0.5, 1, 2, 5, 20};
constexpr std::size_t kToleranceLevel = 2;

// Places a label on each contour, far from the border and from other labels.
void addContourWords(FigureCanvas& canvas, const std::vector<std::vector<ContourSegment>>& contours,
                     const std::vector<std::string>& words, const std::vector<Vector2d>& avoid) {
  constexpr double kNear = 26;
  const Eigen::AlignedBox2d& box = canvas.area().box;
  std::vector<Vector2d> taken;
  for (std::size_t i = 0; i < contours.size(); ++i) {
    double best = kNear;
    Vector2d place(0, 0);
    for (const auto& [from, to] : contours[i]) {
      const Vector2d middle = 0.5 * (from + to);
      double room = std::min({middle.x() - box.min().x(), box.max().x() - middle.x(),
                              1.6 * (middle.y() - box.min().y()), 1.6 * (box.max().y() - middle.y())});
      for (const Vector2d& other : taken) room = std::min(room, (other - middle).norm());
      // A label close to a line is readable, but farther away is better.
      for (const Vector2d& other : avoid) room = std::min(room, kNear + (other - middle).norm());
      if (room <= best) continue;
      best = room;
      place = middle;
    }
    if (best == kNear) continue;
    taken.push_back(place);
    canvas.addText(place + Vector2d(0, 4), words[i], "middle", "halo");
  }
}

}  // namespace

std::string areaFrom(const LevelMap& map, double level) {
  std::string d;
  for (int row = 0; row + 1 < map.rows; ++row) {
    int first = -1;  // start of a run of whole cells, which become one rectangle
    const auto closeRun = [&](int end) {
      if (first < 0) return;
      const auto low = map.points.begin() + row * map.columns;
      const auto high = low + map.columns;
      d += shapePath({low[first], low[end], high[end], high[first]}, true);
      first = -1;
    };
    for (int column = 0; column + 1 < map.columns; ++column) {
      const MapCell cell = cellAt(map, column, row);
      const std::ptrdiff_t num_within = numWithin(cell, level);
      if (num_within < 4) closeRun(column);
      if (num_within == 4 && first < 0) first = column;
      if (num_within > 0 && num_within < 4) d += shapePath(crossings(cell, level, true), true);
    }
    closeRun(map.columns - 1);
  }
  return d;
}

std::vector<ContourSegment> contourAt(const LevelMap& map, double level) {
  std::vector<ContourSegment> segments;
  for (int row = 0; row + 1 < map.rows; ++row) {
    for (int column = 0; column + 1 < map.columns; ++column) {
      const MapCell cell = cellAt(map, column, row);
      if (numWithin(cell, level) % 4 == 0) continue;
      const std::vector<Vector2d> ends = crossings(cell, level, false);
      for (std::size_t i = 0; i + 1 < ends.size(); i += 2) segments.emplace_back(ends[i], ends[i + 1]);
    }
  }
  return segments;
}

std::string contourPath(const std::vector<ContourSegment>& segments) {
  std::string d;
  for (const auto& [from, to] : segments) d += shapePath({from, to}, false);
  return d;
}

Legend addToleranceMap(LevelMap errors, double tolerance_px, FigureCanvas& canvas,
                       const std::vector<Vector2d>& avoid) {
  double least = std::numeric_limits<double>::infinity();
  double most = 0;
  for (const double value : errors.values) {
    if (std::isnan(value)) continue;
    least = std::min(least, value);
    most = std::max(most, value);
  }
  // Errors rise steeply towards the border, so their logarithm is closer to linear between points.
  for (double& value : errors.values) value = std::isnan(value) ? value : std::log(std::max(value, 1e-9));
  std::vector<std::vector<ContourSegment>> contours;
  std::vector<std::string> words;
  Legend legend;
  canvas.addPath(areaFrom(errors, -1e300), "level0");
  double previous = 0;
  for (std::size_t i = 0; i < kMapLevels.size(); ++i) {
    const double level = kMapLevels[i] * tolerance_px;
    words.push_back(fmt::format("{:g} px", level));
    if (least < level && most >= previous)
      legend.emplace_back(fmt::format("level{}", i), fmt::format("{:g} to {:g} px", previous, level));
    previous = level;
    canvas.addPath(areaFrom(errors, std::log(level)), fmt::format("class=\"level{}\"", i + 1));
    contours.push_back(contourAt(errors, std::log(level)));
  }
  if (most >= previous) legend.emplace_back("level6", fmt::format("above {:g} px", previous));
  if (!contours[kToleranceLevel].empty())
    legend.emplace_back("line contour main", fmt::format("tolerance, {:g} px", tolerance_px));
  for (std::size_t i = 0; i < contours.size(); ++i)
    canvas.addPath(contourPath(contours[i]), i == kToleranceLevel ? "contour main" : "contour");
  addContourWords(canvas, contours, words, avoid);
  return legend;
}

std::string toleranceSentence(const Legend& legend, double tolerance_px) {
  const bool has_line =
      std::ranges::any_of(legend, [](const auto& entry) { return entry.first == "line contour main"; });
  return fmt::format("{} the tolerance of {:g} px (--tolerance): blue is within it, yellow to red is not.",
                     has_line ? "The thick line is" : "The colours depend on", tolerance_px);
}

}  // namespace alidade
