// SPDX-License-Identifier: MIT
#include "alidade/report/canvas/tolerance_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include <fmt/format.h>

namespace alidade {
namespace {

using Eigen::Vector2d;

// Multiples of the tolerance at which a colour of the map ends; the colour after the last one has no end.
constexpr std::array<double, 6> kMapLevels = {0.25, 0.5, 1, 2, 5, 20};
constexpr std::size_t kToleranceLevel = 2;

// Places a label on each contour, far from the border and from other labels.
void addContourWords(FigureCanvas& canvas, const std::vector<std::vector<ContourSegment>>& contours,
                     const std::vector<std::string>& words, const PlotArea& area,
                     const std::vector<Vector2d>& avoid) {
  constexpr double kNear = 26;
  std::vector<Vector2d> taken;
  for (std::size_t i = 0; i < contours.size(); ++i) {
    double best = kNear;
    Vector2d place(0, 0);
    for (const auto& [from, to] : contours[i]) {
      const Vector2d middle = 0.5 * (from + to);
      double room =
          std::min({middle.x() - area.box.min().x(), area.box.max().x() - middle.x(),
                    1.6 * (middle.y() - area.box.min().y()), 1.6 * (area.box.max().y() - middle.y())});
      for (const Vector2d& other : taken) room = std::min(room, (other - middle).norm());
      // A label close to a line is readable, but farther away is better.
      for (const Vector2d& other : avoid) room = std::min(room, kNear + (other - middle).norm());
      if (room <= best) continue;
      best = room;
      place = middle;
    }
    if (best == kNear) continue;
    taken.push_back(place);
    canvas.addText(place + Vector2d(0, 4), words[i], "middle", "class=\"halo\"");
  }
}

}  // namespace

Legend addToleranceMap(LevelMap errors, double tolerance_px, const PlotArea& area, FigureCanvas& canvas,
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
  canvas.addPath(areaFrom(errors, -1e300), "class=\"level0\"");
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
    legend.emplace_back("line contour main", fmt::format("your tolerance, {:g} px", tolerance_px));
  for (std::size_t i = 0; i < contours.size(); ++i)
    canvas.addPath(contourPath(contours[i]),
                   i == kToleranceLevel ? "class=\"contour main\"" : "class=\"contour\"");
  addContourWords(canvas, contours, words, area, avoid);
  return legend;
}

std::string toleranceSentence(const Legend& legend, double tolerance_px) {
  const bool has_line =
      std::ranges::any_of(legend, [](const auto& entry) { return entry.first == "line contour main"; });
  return fmt::format("{} your tolerance of {:g} px: blue is within it, yellow to red is not.",
                     has_line ? "The thick line is" : "The colours depend on", tolerance_px);
}

}  // namespace alidade
