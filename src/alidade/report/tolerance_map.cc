// SPDX-License-Identifier: MIT
#include "alidade/report/tolerance_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include <fmt/format.h>

namespace alidade {
namespace {

using Eigen::Vector2d;

// Multiples of the tolerance at which a colour of the map ends; the last one has no end.
constexpr std::array<double, 6> kMapLevels = {0.25, 0.5, 1, 2, 5, 20};
constexpr std::size_t kToleranceLevel = 2;

// A word for each contour, where it is far from the border and from the other words.
void addContourWords(FigureCanvas& canvas, const std::vector<std::vector<ContourSegment>>& contours,
                     const std::vector<std::string>& words, const PlotArea& area) {
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

std::vector<std::pair<std::string, std::string>> addToleranceMap(LevelMap errors, double tolerance_px,
                                                                 const PlotArea& area, FigureCanvas& canvas) {
  // Errors grow steeply towards the border: their logarithm is nearer to linear between points.
  for (double& value : errors.values) value = std::isnan(value) ? value : std::log(std::max(value, 1e-9));
  std::vector<std::vector<ContourSegment>> contours;
  std::vector<std::string> words;
  std::vector<std::pair<std::string, std::string>> legend;
  canvas.addPath(areaFrom(errors, -1e300), "class=\"level0\"");
  std::string previous = "0";
  for (std::size_t i = 0; i < kMapLevels.size(); ++i) {
    const double level = kMapLevels[i] * tolerance_px;
    words.push_back(fmt::format("{:g} px", level));
    legend.emplace_back(fmt::format("level{}", i), fmt::format("{} to {:g}", previous, level));
    previous = fmt::format("{:g}", level);
    canvas.addPath(areaFrom(errors, std::log(level)), fmt::format("class=\"level{}\"", i + 1));
    contours.push_back(contourAt(errors, std::log(level)));
  }
  legend.emplace_back("level6", "above " + previous + " px");
  for (std::size_t i = 0; i < contours.size(); ++i)
    canvas.addPath(contourPath(contours[i]),
                   i == kToleranceLevel ? "class=\"contour main\"" : "class=\"contour\"");
  addContourWords(canvas, contours, words, area);
  return legend;
}

}  // namespace alidade
