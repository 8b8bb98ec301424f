// SPDX-License-Identifier: MIT
#include "alidade/report/figures/image_figures.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "alidade/core/number_text.h"
#include "alidade/core/statistics.h"
#include "alidade/report/canvas/level_map.h"
#include "alidade/report/canvas/tolerance_map.h"

namespace alidade {
namespace {

using Eigen::Vector2d;

constexpr std::size_t kMostDots = 6000;  // more would overlap and make a large file
constexpr std::size_t kMostResiduals = 3000;

LevelMap errorMap(const Accuracy& accuracy, const ImageSize& size, const PlotArea& area) {
  LevelMap map{
      .columns = accuracy.columns, .rows = accuracy.rows, .values = accuracy.error_px, .point_at = {}};
  map.point_at = [&accuracy, size, area](int column, int row) {
    // The outer points represent the border itself.
    const Vector2d pixel = Vector2d(column * (size.width - 1.0) / (accuracy.columns - 1),
                                    row * (size.height - 1.0) / (accuracy.rows - 1));
    const Vector2d share(column / (accuracy.columns - 1.0), row / (accuracy.rows - 1.0));
    return area.at(pixel + share - Vector2d(0.5, 0.5));
  };
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
  for (const ReportedView& view : data.views) {
    for (const ReportedCorner& corner : view.corners) {
      const int column = cellIndex(corner.pixel.x(), data.size.width, columns);
      const int row = cellIndex(corner.pixel.y(), data.size.height, rows);
      ErrorCell& cell = cells[static_cast<std::size_t>(row * columns + column)];
      ++cell.count;
      cell.arrow += corner.error_px;
      cell.rms_px += corner.error_px.squaredNorm();
    }
  }
  for (ErrorCell& cell : cells) {
    if (cell.count == 0) continue;
    cell.rms_px = std::sqrt(cell.rms_px / cell.count);
    cell.arrow *= arrow_scale / cell.count;
  }
  return cells;
}

// Every n-th corner, so that at most `most` remain.
template <class Visit>
void visitSample(const ReportData& data, std::size_t most, Visit visit) {
  const std::size_t step = (numCorners(data) + most - 1) / std::max<std::size_t>(most, 1);
  std::size_t i = 0;
  for (const ReportedView& view : data.views) {
    for (const ReportedCorner& corner : view.corners) {
      if (step <= 1 || i % step == 0) visit(corner);
      ++i;
    }
  }
}

// Magnification of arrows with which the longest usual error spans `length` in the drawing.
double magnification(const ReportData& data, const PlotArea& area, double length) {
  std::vector<double> lengths;
  visitSample(data, kMostResiduals,
              [&](const ReportedCorner& corner) { lengths.push_back(corner.error_px.norm()); });
  if (lengths.empty()) return 1;
  const double usual = quantile95(std::move(lengths)) * area.scale();
  return usual > 0 ? roundBelow(length / usual) : 1;
}

}  // namespace

Figure accuracyFigure(const ReportData& data, bool is_by_covariance) {
  const Accuracy& accuracy = *data.accuracy;
  const ImagePlot plot = imagePlot(data.size);
  FigureCanvas canvas(plot.legend_top);
  const Vector2d low = plot.area.box.min();
  const Vector2d high = plot.area.box.max();
  canvas.addRect(low, high, "class=\"blind\"");
  const LevelMap map = errorMap(accuracy, data.size, plot.area);
  LevelMap covered = map;
  for (std::size_t i = 0; i < covered.values.size(); ++i) covered.values[i] = accuracy.is_covered[i] ? 1 : 0;
  const std::vector<ContourSegment> outline = contourAt(covered, 0.5);
  std::vector<Vector2d> on_outline;
  for (const auto& [from, to] : outline) on_outline.push_back(from);
  Legend legend = addToleranceMap(map, data.tolerance_px, plot.area, canvas, on_outline);
  canvas.addPath(contourPath(outline), "class=\"outline\"");
  // Keeps the ring whole, even if the worst pixel is at the border.
  constexpr double kRing = 5;
  const Vector2d inset = Vector2d::Constant(kRing + 1);
  const Vector2d worst = plot.area.at(accuracy.worst_pixel).cwiseMax(low + inset).cwiseMin(high - inset);
  canvas.addCircle(worst, kRing, "class=\"worst worst-halo\"");
  canvas.addCircle(worst, kRing, "class=\"worst\"");
  canvas.addImageFrame(plot.area);
  if (std::ranges::find(accuracy.is_covered, true) != accuracy.is_covered.end())
    legend.emplace_back("line outline", "boards were seen inside");
  legend.emplace_back("dot worst", fmt::format("worst, {} px", twoDigits(accuracy.worst_px)));
  if (hasBlindPixels(accuracy)) legend.emplace_back("blind", "no ray");
  canvas.addLegend({plot.area.box.min().x(), plot.legend_top}, legend);
  Figure figure{.id = "accuracy", .title = "Accuracy over the image"};
  const std::string tolerance = toleranceSentence(legend, data.tolerance_px);
  figure.reading =
      is_by_covariance
          ? fmt::format(
                "Each colour is an error that the covariance of the file allows a distant point in 95 of 100 "
                "cases. {} Errors of the lens model are not in it.",
                tolerance)
          : fmt::format(
                "Each colour is an error that a projected point does not exceed in 95 of 100 cases. {} The "
                "dashed line surrounds the part where boards were seen.",
                tolerance);
  figure.alt = accuracyAlt(data, is_by_covariance);
  if (is_by_covariance) return canvas.drawn(std::move(figure));
  return canvas.drawn(std::move(figure),
                      fmt::format("data-map=\"accuracy\" data-box=\"{} {} {} {}\"", coordinate(low.x()),
                                  coordinate(low.y()), coordinate(high.x()), coordinate(high.y())));
}

Figure coverageFigure(const CalibrationEvidence& data) {
  const ImagePlot plot = imagePlot(data.size);
  FigureCanvas canvas(plot.legend_top);
  const PlotArea& area = plot.area;
  const CoverageReport& cells = data.coverage;
  const int most = std::max(1, *std::ranges::max_element(cells.num_corners));
  int num_seen = 0;
  int num_with_ray = 0;
  canvas.addRect(area.box.min(), area.box.max(), "class=\"paper\"");
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
  visitSample(data, kMostDots,
              [&](const ReportedCorner& corner) { dots += "M" + pointText(area.at(corner.pixel)) + "h0"; });
  canvas.addPath(dots, "class=\"corners\"");
  canvas.addImageFrame(area);
  Legend legend = {{"dot corner", "corner of a board"}, {"seen", "cell with corners"}, {"empty", "without"}};
  if (num_with_ray < cells.columns * cells.rows) legend.emplace_back("blind", "no ray");
  canvas.addLegend({area.box.min().x(), plot.legend_top}, legend);
  Figure figure{.id = "coverage", .title = "Where corners were seen"};
  figure.reading =
      "Each dot is a corner that was used; parts of the image without dots are extrapolated, so put the "
      "board there in further photographs.";
  figure.alt =
      fmt::format("{} corners in {} of {} cells of the image.", numCorners(data), num_seen, num_with_ray);
  return canvas.drawn(std::move(figure));
}

Figure imageResidualsFigure(const ReportData& data) {
  const ImagePlot plot = imagePlot(data.size);
  FigureCanvas canvas(plot.legend_top);
  const PlotArea& area = plot.area;
  const auto [columns, rows] = cellsFor(data.size, 12);
  const double length = 0.9 * area.box.sizes().x() / columns;
  const double times = magnification(data, area, length);
  const std::vector<ErrorCell> cells = residualCells(data, columns, rows, times * area.scale());
  const double most = std::ranges::max_element(cells, {}, &ErrorCell::rms_px)->rms_px;
  canvas.addRect(area.box.min(), area.box.max(), "class=\"paper\"");
  const std::string means = canvas.addErrorCells(area, columns, rows, cells);
  std::string single;
  visitSample(data, kMostResiduals, [&](const ReportedCorner& corner) {
    const Vector2d from = area.at(corner.pixel);
    single += pathThrough({from, from + times * area.scale() * corner.error_px});
  });
  canvas.open("clip-path=\"url(#residuals-clip)\"");
  canvas.addPath(single, "class=\"residuals\"");
  canvas.addMeanArrows(means);
  canvas.close();
  canvas.addClip("residuals-clip", area);
  canvas.addImageFrame(area);
  const double scale_px = roundBelow(length / (times * area.scale()));
  Legend legend = warmthLegend(most);
  legend.insert(legend.begin(), {{"line residuals", fmt::format("single corner ({})", timesLonger(times))},
                                 {"line mean", "mean of a cell"}});
  canvas.addLegend({area.box.min().x(), plot.legend_top}, legend);
  Figure figure{.id = "image-residuals", .title = "Reprojection errors over the image"};
  figure.reading =
      "Thin lines lead from each detected corner to where the camera projects it; they should point in all "
      "directions, and where the thick mean arrows are long and agree, the lens model does not describe the "
      "lens.";
  figure.alt = fmt::format(
      "Reprojection errors of {} corners with an RMS of {} px; the largest RMS of a cell is {} px.",
      numCorners(data), shortNumber(data.rms_px), shortNumber(most));
  return canvas.drawn(std::move(figure), fmt::format("data-scale-px=\"{:g}\"", scale_px));
}

}  // namespace alidade
