// SPDX-License-Identifier: MIT
#include "alidade/report/figures/difference_figure.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "alidade/compare/projection_difference.h"
#include "alidade/report/canvas/tolerance_map.h"

namespace alidade {
namespace {

using Eigen::Vector2d;

constexpr int kDifferenceArrows = 14;  // along the longer side

// Adds arrows at every n-th point of the grid. @returns their magnification
double addDifferenceArrows(const ProjectionDifference& difference, const PlotArea& area,
                           FigureCanvas& canvas) {
  const int step = std::max(1, std::max(difference.columns, difference.rows) / kDifferenceArrows);
  const double longest = 0.9 * area.box.sizes().maxCoeff() / kDifferenceArrows;
  const double times = roundBelow(longest / (difference.p95_px * area.scale()));
  std::string arrows;
  for (int row = step / 2; row < difference.rows; row += step) {
    for (int column = step / 2; column < difference.columns; column += step) {
      const auto i = static_cast<std::size_t>(row * difference.columns + column);
      if (!difference.difference_px[i].allFinite()) continue;
      Vector2d along = times * area.scale() * difference.difference_px[i];
      if (along.norm() > 1.5 * longest) along *= 1.5 * longest / along.norm();
      arrows += arrowPath(area.at(difference.pixels[i]), along);
    }
  }
  canvas.open("clip-path=\"url(#difference-clip)\"");
  canvas.addMeanArrows(arrows);
  canvas.close();
  canvas.addClip("difference-clip", area);
  return times;
}

}  // namespace

Figure differenceFigure(const ReportData& data, const RivalCamera& rival) {
  const ComparedCamera own{&data.camera, data.size, data.covariance};
  const ComparedCamera other{&rival.camera, rival.size, rival.covariance};
  const ProjectionDifference difference = projectionDifference(own, other);
  const ImagePlot plot = imagePlot(data.size);
  const PlotArea& area = plot.area;
  FigureCanvas canvas(plot.legend_top);
  canvas.addRect(area.box.min(), area.box.max(), "class=\"blind\"");
  Figure figure{.id = "difference", .title = "Difference from " + rival.name};
  Legend legend;
  if (difference.is_converged && difference.num_compared > 0 && difference.columns > 1 &&
      difference.rows > 1) {
    LevelMap map{.columns = difference.columns, .rows = difference.rows, .values = {}, .point_at = {}};
    for (const Vector2d& d : difference.difference_px)
      map.values.push_back(d.allFinite() ? d.norm() : std::numeric_limits<double>::quiet_NaN());
    map.point_at = [&](int column, int row) {
      return area.at(difference.pixels[static_cast<std::size_t>(row * difference.columns + column)]);
    };
    legend = addToleranceMap(map, data.tolerance_px, area, canvas);
    figure.reading =
        "Each colour is the difference between the pixels of a distant point in the two cameras, after the "
        "best rotation, and each arrow leads from this camera's pixel to the other's. " +
        toleranceSentence(legend, data.tolerance_px);
    constexpr double kRoundingPx = 1e-6;  // smaller differences are irrelevant
    if (difference.p95_px > kRoundingPx) {
      const double times = addDifferenceArrows(difference, area, canvas);
      legend.emplace_back("line mean", fmt::format("difference ({})", timesLonger(times)));
    }
    if (difference.num_compared < static_cast<int>(difference.pixels.size()))
      legend.emplace_back("blind", "not comparable");
    figure.alt = fmt::format(
        "The two cameras differ by {} px on average, and by at most {} px in 95 percent of the image.",
        twoDigits(difference.mean_px), twoDigits(difference.p95_px));
  } else {
    legend.emplace_back("blind", "not comparable");
    figure.reading = figure.alt = "The two cameras cannot be compared: they have too little in common.";
  }
  canvas.addImageFrame(area);
  canvas.addLegend({area.box.min().x(), plot.legend_top}, legend);
  return canvas.drawn(std::move(figure), fmt::format("data-p95=\"{:.9g}\"", difference.p95_px));
}

}  // namespace alidade
