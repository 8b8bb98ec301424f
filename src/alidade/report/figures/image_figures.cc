// SPDX-License-Identifier: MIT
#include "alidade/report/figures/camera_figures.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "alidade/compare/projection_difference.h"
#include "alidade/core/mapped.h"
#include "alidade/core/number_text.h"
#include "alidade/core/statistics.h"
#include "alidade/report/canvas/level_map.h"

namespace alidade {
namespace {

using Eigen::Vector2d;

constexpr std::size_t kMostDots = 6000;  // more would overlap and make a large file
constexpr std::size_t kMostResiduals = 3000;

LevelMap errorMap(const Accuracy& accuracy, const ImageSize& size, const FigureCanvas& canvas) {
  LevelMap map{.columns = accuracy.columns, .rows = accuracy.rows, .values = accuracy.error_px};
  for (int row = 0; row < map.rows; ++row) {
    for (int column = 0; column < map.columns; ++column) {
      // The outer points represent the border itself.
      const Vector2d pixel = Vector2d(column * (size.width - 1.0) / (map.columns - 1),
                                      row * (size.height - 1.0) / (map.rows - 1));
      const Vector2d share(column / (map.columns - 1.0), row / (map.rows - 1.0));
      map.points.push_back(canvas.at(Vector2d(pixel + share - Vector2d(0.5, 0.5))));
    }
  }
  return map;
}

std::string accuracyAlt(const ReportData& data, bool is_by_covariance) {
  const Accuracy& accuracy = *data.accuracy;
  const std::string covered = is_by_covariance ? ""
                                               : fmt::format("at most {} px where boards were seen, ",
                                                             twoDigits(accuracy.covered_px));
  return fmt::format(
      "Map of the 95 percent error over the image: {}{:g} px or less in {} of {}, worst {} px at pixel "
      "({:.0f}, {:.0f}).",
      covered, data.tolerance_px, percentText(accuracy.shareWithin(data.tolerance_px)), wholeName(accuracy),
      twoDigits(accuracy.worst_px), accuracy.worst_pixel.x(), accuracy.worst_pixel.y());
}

// Numbers of columns and rows for nearly square cells.
std::pair<int, int> cellsFor(const ImageSize& size, int along_longer) {
  const double cell = static_cast<double>(std::max(size.width, size.height)) / along_longer;
  return {std::max(1, static_cast<int>(std::lround(size.width / cell))),
          std::max(1, static_cast<int>(std::lround(size.height / cell)))};
}

int cellIndex(double pixel, int side, int count) {
  return std::clamp(static_cast<int>((pixel + 0.5) * count / side), 0, count - 1);
}

// @param arrow_scale  units of the drawing per px
std::vector<ErrorCell> residualCells(const ReportData& data, int columns, int rows, double arrow_scale) {
  std::vector<ErrorCell> cells(static_cast<std::size_t>(columns * rows));
  for (const CornerError& corner : allCorners(data)) {
    const int column = cellIndex(corner.pixel.x(), data.size.width, columns);
    const int row = cellIndex(corner.pixel.y(), data.size.height, rows);
    ErrorCell& cell = cells[static_cast<std::size_t>(row * columns + column)];
    ++cell.count;
    cell.arrow += corner.error_px;
    cell.rms_px += corner.error_px.squaredNorm();
  }
  for (ErrorCell& cell : cells) {
    if (cell.count == 0) continue;
    cell.rms_px = std::sqrt(cell.rms_px / cell.count);
    cell.arrow *= arrow_scale / cell.count;
  }
  return cells;
}

// Every n-th corner, so that at most `most` remain.
std::vector<CornerError> someCorners(const ReportData& data, std::size_t most) {
  const std::vector<CornerError> all = allCorners(data);
  const std::size_t step = std::max<std::size_t>(1, (all.size() + most - 1) / most);
  std::vector<CornerError> some;
  for (std::size_t i = 0; i < all.size(); i += step) some.push_back(all[i]);
  return some;
}

// Magnification of arrows with which the longest usual error spans `length` in the drawing.
double magnification(const std::vector<CornerError>& corners, const PlotArea& area, double length) {
  if (corners.empty()) return 1;
  const double usual =
      quantile95(mapped(corners, [](const CornerError& corner) { return corner.error_px.norm(); })) *
      area.scale();
  return usual > 0 ? roundBelow(length / usual) : 1;
}

constexpr int kDifferenceArrows = 14;  // along the longer side

// Adds arrows at every n-th point of the grid. @returns their magnification
double addDifferenceArrows(const ProjectionDifference& difference, FigureCanvas& canvas) {
  const PlotArea& area = canvas.area();
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
  canvas.addClip("difference-clip");
  return times;
}

}  // namespace

Figure accuracyFigure(const ReportData& data, bool is_by_covariance) {
  const Accuracy& accuracy = *data.accuracy;
  FigureCanvas canvas(data.size, "blind");
  const Vector2d low = canvas.area().box.min();
  const Vector2d high = canvas.area().box.max();
  const LevelMap map = errorMap(accuracy, data.size, canvas);
  LevelMap covered = map;
  for (std::size_t i = 0; i < covered.values.size(); ++i) covered.values[i] = accuracy.is_covered[i] ? 1 : 0;
  const std::vector<ContourSegment> outline = contourAt(covered, 0.5);
  std::vector<Vector2d> on_outline;
  for (const auto& [from, to] : outline) on_outline.push_back(from);
  Legend legend = addToleranceMap(map, data.tolerance_px, canvas, on_outline);
  canvas.addPath(contourPath(outline), "outline");
  // Keeps the ring whole, even if the worst pixel is at the border.
  constexpr double kRing = 5;
  const Vector2d inset = Vector2d::Constant(kRing + 1);
  canvas.addRing(canvas.at(accuracy.worst_pixel).cwiseMax(low + inset).cwiseMin(high - inset), kRing);
  canvas.addImageFrame();
  if (std::ranges::find(accuracy.is_covered, true) != accuracy.is_covered.end())
    legend.emplace_back("line outline", "boards were seen inside");
  legend.emplace_back("dot worst", fmt::format("worst, {} px", twoDigits(accuracy.worst_px)));
  if (hasBlindPixels(accuracy)) legend.emplace_back("blind", "no ray");
  const char* const reading =
      is_by_covariance
          ? "Each colour is an error that the covariance of the file allows a distant point in 95 of 100 "
            "cases. {} Errors of the lens model are not in it."
          : "Each colour is an error that a projected point does not exceed in 95 of 100 cases. {} The "
            "dashed line surrounds the part where boards were seen.";
  return canvas.drawn(
      {.id = "accuracy",
       .title = "Accuracy over the image",
       .reading = fmt::format(fmt::runtime(reading), toleranceSentence(legend, data.tolerance_px)),
       .alt = accuracyAlt(data, is_by_covariance)},
      legend,
      is_by_covariance ? ""
                       : fmt::format("data-map=\"accuracy\" data-box=\"{} {} {} {}\"", coordinate(low.x()),
                                     coordinate(low.y()), coordinate(high.x()), coordinate(high.y())));
}

Figure coverageFigure(const CalibrationEvidence& data) {
  FigureCanvas canvas(data.size, "paper");
  const PlotArea& area = canvas.area();
  const CoverageReport& cells = data.coverage;
  const int most = std::max(1, *std::ranges::max_element(cells.num_corners));
  int num_seen = 0;
  int num_with_ray = 0;
  for (int row = 0; row < cells.rows; ++row) {
    for (int column = 0; column < cells.columns; ++column) {
      const int count = cells.num_corners[static_cast<std::size_t>(row * cells.columns + column)];
      const Vector2d cell = area.box.sizes().cwiseQuotient(Vector2d(cells.columns, cells.rows));
      const Vector2d low = area.box.min() + cell.cwiseProduct(Vector2d(column, row));
      num_seen += count > 0 ? 1 : 0;
      num_with_ray += count >= 0 ? 1 : 0;
      const double strength = count <= 0 ? 1 : 0.10 + 0.35 * std::sqrt(static_cast<double>(count) / most);
      canvas.addRect(low, low + cell,
                     fmt::format("class=\"{}\" fill-opacity=\"{:.2f}\" data-count=\"{}\"",
                                 count < 0    ? "blind"
                                 : count == 0 ? "empty"
                                              : "seen",
                                 strength, std::max(0, count)));
    }
  }
  std::string dots;
  for (const CornerError& corner : someCorners(data, kMostDots))
    dots += "M" + pointText(canvas.at(corner.pixel)) + "h0";
  canvas.addPath(dots, "corners");
  canvas.addImageFrame();
  Legend legend = {{"dot corner", "corner of a board"}, {"seen", "cell with corners"}, {"empty", "without"}};
  if (num_with_ray < cells.columns * cells.rows) legend.emplace_back("blind", "no ray");
  return canvas.drawn(
      {.id = "coverage",
       .title = "Where corners were seen",
       .reading = "Each dot is a corner that was used; parts of the image without dots are extrapolated, so "
                  "put the board there in further photographs.",
       .alt = fmt::format("{} corners in {} of {} cells of the image.", allCorners(data).size(), num_seen,
                          num_with_ray)},
      legend);
}

Figure imageResidualsFigure(const ReportData& data) {
  FigureCanvas canvas(data.size, "paper");
  const PlotArea& area = canvas.area();
  const auto [columns, rows] = cellsFor(data.size, 12);
  const double length = 0.9 * area.box.sizes().x() / columns;
  const std::vector<CornerError> sample = someCorners(data, kMostResiduals);
  const double times = magnification(sample, area, length);
  const std::vector<ErrorCell> cells = residualCells(data, columns, rows, times * area.scale());
  const double most = std::ranges::max_element(cells, {}, &ErrorCell::rms_px)->rms_px;
  const std::string means = canvas.addErrorCells(columns, rows, cells);
  std::string single;
  for (const CornerError& corner : sample) {
    const Vector2d from = canvas.at(corner.pixel);
    single += pathThrough({from, from + times * area.scale() * corner.error_px});
  }
  canvas.open("clip-path=\"url(#residuals-clip)\"");
  canvas.addPath(single, "residuals");
  canvas.addMeanArrows(means);
  canvas.close();
  canvas.addClip("residuals-clip");
  canvas.addImageFrame();
  const double scale_px = roundBelow(length / (times * area.scale()));
  Legend legend = warmthLegend(most);
  legend.insert(legend.begin(), {{"line residuals", fmt::format("single corner ({})", timesLonger(times))},
                                 {"line mean", "mean of a cell"}});
  return canvas.drawn(
      {.id = "image-residuals",
       .title = "Reprojection errors over the image",
       .reading = "Thin lines lead from each detected corner to where the camera projects it; they should "
                  "point in all directions, and where the thick mean arrows are long and agree, the lens "
                  "model does not describe the lens.",
       .alt = fmt::format(
           "Reprojection errors of {} corners with an RMS of {} px; the largest RMS of a cell is {} px.",
           allCorners(data).size(), shortNumber(data.rms_px), shortNumber(most))},
      legend, fmt::format("data-scale-px=\"{:g}\"", scale_px));
}

Figure differenceFigure(const ReportData& data, const RivalCamera& rival) {
  const ComparedCamera own{&data.camera, data.size, data.covariance};
  const ComparedCamera other{&rival.camera, rival.size, rival.covariance};
  const ProjectionDifference difference = projectionDifference(own, other);
  FigureCanvas canvas(data.size, "blind");
  Figure figure{.id = "difference", .title = "Difference from " + rival.name};
  Legend legend;
  if (difference.is_converged && difference.num_compared > 0 && difference.columns > 1 &&
      difference.rows > 1) {
    LevelMap map{
        .columns = difference.columns, .rows = difference.rows, .points = canvas.at(difference.pixels)};
    for (const Vector2d& d : difference.difference_px)
      map.values.push_back(d.allFinite() ? d.norm() : std::numeric_limits<double>::quiet_NaN());
    legend = addToleranceMap(map, data.tolerance_px, canvas);
    figure.reading =
        "Each colour is the difference between the pixels of a distant point in the two cameras, after the "
        "best rotation, and each arrow leads from this camera's pixel to the other's. " +
        toleranceSentence(legend, data.tolerance_px);
    constexpr double kRoundingPx = 1e-6;  // smaller differences are irrelevant
    if (difference.p95_px > kRoundingPx) {
      const double times = addDifferenceArrows(difference, canvas);
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
  canvas.addImageFrame();
  return canvas.drawn(std::move(figure), legend, fmt::format("data-p95=\"{:.9g}\"", difference.p95_px));
}

}  // namespace alidade
