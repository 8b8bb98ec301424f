// SPDX-License-Identifier: MIT
#include "alidade/report/figures/camera_figures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <Eigen/Cholesky>
#include <boost/math/distributions/normal.hpp>

#include "alidade/print/ink_of_board.h"

namespace alidade {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

// All errors along x and y of the image, sorted.
std::vector<double> sortedComponents(const ReportData& data) {
  std::vector<double> components;
  for (const CornerError& corner : allCorners(data))
    components.insert(components.end(), {corner.error_px.x(), corner.error_px.y()});
  std::ranges::sort(components);
  return components;
}

double rootMeanSquare(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value * value;
  return values.empty() ? 0 : std::sqrt(sum / static_cast<double>(values.size()));
}

// Least squares of the displacement of one point of a board, metres on the board: views at a grazing angle
// contribute little.
struct PointDisplacement {
  Matrix2d information = Matrix2d::Zero();
  Vector2d sum{0, 0};
  int count = 0;

  Vector2d offset{0, 0};  // estimated by the calibration

  [[nodiscard]] Vector2d mean() const { return offset + information.ldlt().solve(sum); }
  /// Standard deviation of the mean in the worse direction, for this corner noise.
  [[nodiscard]] double std(double sigma_px) const {
    const double half_trace = 0.5 * information.trace();
    const double least =
        half_trace - std::sqrt(std::max(0.0, half_trace * half_trace - information.determinant()));
    return least > 0 ? sigma_px / std::sqrt(least) : std::numeric_limits<double>::infinity();
  }
};

std::vector<PointDisplacement> displacements(const ReportData& data, std::size_t board) {
  const FitBoard& on = data.boards[board];
  std::vector<PointDisplacement> points(static_cast<std::size_t>(on.target.numCorners()));
  for (std::size_t i = 0; i < on.shape.offsets_m.size(); ++i)
    points[i].offset = on.shape.offsets_m[i].head<2>();
  for (const ReportedView& view : data.views) {
    if (view.board != board) continue;
    const Eigen::Matrix<double, 3, 2> along = view.camera_from_board.rotation.matrix().leftCols<2>();
    for (const CornerError& corner : view.corners) {
      const Eigen::Vector3d point = view.camera_from_board * pointOn(on.target, on.shape, corner.id);
      Eigen::Matrix<double, 2, 3, Eigen::RowMajor> of_point;
      if (!data.camera.projectPoint(point, of_point.data()).ok()) continue;
      const Matrix2d pixel_per_metre = of_point * along;
      PointDisplacement& at = points[static_cast<std::size_t>(corner.id)];
      at.information += pixel_per_metre.transpose() * pixel_per_metre;
      at.sum -= pixel_per_metre.transpose() * corner.error_px;  // observed minus projected
      ++at.count;
    }
  }
  return points;
}

// The area of a board in a drawing.
PlotArea boardArea(const BoardInk& ink) {
  const Vector2d size_mm = 1e3 * ink.extent.sizes();
  PlotArea area = imageArea({.width = static_cast<int>(std::lround(10 * size_mm.x())),
                             .height = static_cast<int>(std::lround(10 * size_mm.y()))},
                            FigureCanvas::kWidth);
  area.low = ink.extent.min();
  area.high = ink.extent.max();
  return area;
}

std::string circlePath(const Vector2d& middle, double radius) {
  return "M" + pointText(middle - Vector2d(radius, 0)) +
         fmt::format("a{0},{0} 0 1 0 {1},0a{0},{0} 0 1 0 -{1},0Z", coordinate(radius),
                     coordinate(2 * radius));
}

std::string inkPath(const BoardInk& ink, const FigureCanvas& canvas) {
  std::string d;
  for (const Eigen::AlignedBox2d& box : ink.boxes) d += pathThrough(canvas.at(cornersOf(box)), true);
  for (const Eigen::AlignedBox2d& disc : ink.discs)
    d += circlePath(canvas.at(disc.center()), 0.5 * disc.sizes().x() * canvas.area().scale());
  return d;
}

double highestOf(const BoardShape& shape) {
  double highest_m = 0;
  for (const Eigen::Vector3d& offset : shape.offsets_m) highest_m = std::max(highest_m, std::abs(offset.z()));
  return highest_m;
}

// Squares coloured by the height of points above or below the board's plane.
void addHeights(const Board& target, const BoardShape& shape, FigureCanvas& canvas) {
  const double highest_m = highestOf(shape);
  if (!(highest_m > 0)) return;
  const Vector2d half = Vector2d::Constant(0.28 * target.spacing() * canvas.area().scale());
  for (std::size_t id = 0; id < shape.offsets_m.size(); ++id) {
    const Vector2d at = canvas.at(target.corners()[id].head<2>());
    const double across_m = shape.offsets_m[id].z();
    canvas.addRect(
        at - half, at + half,
        fmt::format("class=\"{}\" fill-opacity=\"{:.2f}\" data-across-mm=\"{:.4g}\"",
                    across_m > 0 ? "cold" : "warm", 0.7 * std::abs(across_m) / highest_m, 1e3 * across_m));
  }
}

std::string displacementReading(const BoardShape& shape) {
  const std::string reading =
      "Each arrow shows where the views together see a point of the board, compared with where it should be. "
      "Arrows longer than the radius of the circles, which is the noise, mean that the print is distorted or "
      "the board is bent.";
  if (shape.offsets_m.empty()) return reading;
  return fmt::format(
      "Already corrected in the calibration. {} Coloured squares show how far points lie in front of or behind "
      "the board's plane: {} mm (RMS).",
      reading, twoDigits(1e3 * offsetRms(shape).y()));
}

}  // namespace

Figure boardResidualsFigure(const ReportData& data, std::size_t board) {
  const Board& target = data.boards[board].target;
  const BoardInk ink = inkOf(target);
  FigureCanvas canvas(boardArea(ink), FigureCanvas::kMarks - 12);  // no marks here
  const PlotArea& area = canvas.area();
  canvas.addArea("paper");
  canvas.addPath(inkPath(ink, canvas), "ink");
  const std::vector<PointDisplacement> points = displacements(data, board);
  std::vector<double> lengths;
  double noise_m = 0;
  for (const PointDisplacement& point : points) {
    if (point.count < 2) continue;
    lengths.push_back(point.mean().norm());
    noise_m += point.std(data.coordinate_sigma_px);
  }
  const BoardShape& shape = data.boards[board].shape;
  const double longest = lengths.empty() ? 0 : *std::ranges::max_element(lengths);
  if (!lengths.empty()) noise_m /= static_cast<double>(lengths.size());
  const double spacing = target.spacing() * area.scale();
  const double times = longest > 0 ? roundBelow(0.9 * spacing / (longest * area.scale())) : 1;
  std::string arrows;
  std::string circles;
  const double noise_radius = std::min(times * area.scale() * noise_m, 0.5 * spacing);
  for (std::size_t id = 0; id < points.size(); ++id) {
    const Vector2d at = area.at(target.corners()[id].head<2>());
    circles += circlePath(at, std::max(noise_radius, 0.8));
    if (points[id].count >= 2) arrows += arrowPath(at, times * area.scale() * points[id].mean());
  }
  addHeights(target, shape, canvas);
  canvas.addPath(circles, "noise");
  canvas.addMeanArrows(arrows);
  canvas.addArea("frame");
  Legend legend;
  if (longest > 0) {
    const double scale_m = roundBelow(longest);
    legend.emplace_back(
        fmt::format("arrow {:.1f} mean", times * area.scale() * scale_m),
        fmt::format("{:g} mm; the longest is {} mm", 1e3 * scale_m, twoDigits(1e3 * longest)));
  }
  legend.emplace_back("dot noise", fmt::format("noise, {} mm", twoDigits(1e3 * noise_m)));
  if (const double highest_m = highestOf(shape); highest_m > 0) {
    legend.emplace_back("warm strong-fill",
                        fmt::format("{} mm in front of the plane", twoDigits(1e3 * highest_m)));
    legend.emplace_back("cold strong-fill", "as far behind it");
  }
  return canvas.drawn(
      {.id = "board-residuals" + (board == 0 ? "" : std::to_string(board + 1)),
       .title = "Displacement of the board's points",
       .reading = displacementReading(shape),
       .alt = fmt::format("Mean displacement of the points of {}: at most {} mm, with a noise of {} mm.",
                          target.spec(), shortNumber(1e3 * longest), shortNumber(1e3 * noise_m))},
      legend);
}

std::vector<Figure> boardResidualsFigures(const ReportData& data) {
  std::vector<Figure> figures;
  for (std::size_t b = 0; b < data.boards.size(); ++b)
    if (std::ranges::find(data.views, b, &ReportedView::board) != data.views.end())
      figures.push_back(boardResidualsFigure(data, b));
  return figures;
}

Figure histogramFigure(const ReportData& data) {
  constexpr int kBars = 40;
  constexpr double kRange = 4;  // standard deviations on each side
  const std::vector<double> components = sortedComponents(data);
  const double sigma = rootMeanSquare(components);
  const double end = sigma > 0 ? kRange * sigma : 1;
  std::array<int, kBars> counts{};
  int num_beyond3 = 0;
  for (const double value : components) {
    const double at = std::clamp(kBars * (value + end) / (2 * end), 0.0, kBars - 1.0);
    ++counts[static_cast<std::size_t>(at)];
    num_beyond3 += std::abs(value) > 3 * sigma ? 1 : 0;
  }
  const auto total = static_cast<double>(std::max<std::size_t>(1, components.size()));
  const double step = 2 * end / kBars;
  const auto normal = [&](double x) {
    return sigma > 0 ? total * step / (sigma * std::sqrt(2 * std::numbers::pi)) *
                           std::exp(-0.5 * (x / sigma) * (x / sigma))
                     : 0;
  };
  const double most = std::max<double>(*std::ranges::max_element(counts), normal(0));
  FigureCanvas canvas(Vector2d(-end, 0), Vector2d(end, 1.08 * most));
  canvas.addAxes("error along x or y of the image, px", "number of errors");
  for (int i = 0; i < kBars; ++i) {
    const double left = -end + i * step;
    const int count = counts[static_cast<std::size_t>(i)];
    canvas.addRect(canvas.at(left, count) + Vector2d(0.5, 0), canvas.at(left + step, 0) - Vector2d(0.5, 0),
                   fmt::format("class=\"bar\" data-count=\"{}\"", count));
  }
  std::vector<Vector2d> curve;
  for (int i = 0; i <= 80; ++i) {
    const double x = -end + i * end / 40;
    curve.push_back(canvas.at(x, normal(x)));
  }
  canvas.addPath(pathThrough(curve), "reference");
  return canvas.drawn(
      {.id = "histogram",
       .title = "Distribution of the errors",
       .reading = "The bars should follow the curve: a sharper peak with long tails means that some corners "
                  "or images are much worse than the others.",
       .alt = fmt::format(
           "Histogram of {} errors with a standard deviation of {} px; {:.2f} percent lie beyond three "
           "standard deviations, where a normal distribution has 0.27 percent.",
           components.size(), shortNumber(sigma), 100 * num_beyond3 / total)},
      {{"bar", "errors; the outer bars hold all beyond"}, {"line reference", "normal distribution"}});
}

Figure normalPlotFigure(const ReportData& data) {
  constexpr std::size_t kMostPoints = 240;
  constexpr double kRange = 3.6;
  const std::vector<double> components = sortedComponents(data);
  const double sigma = rootMeanSquare(components);
  const std::size_t count = components.size();
  double most = kRange * sigma;
  if (count > 0) most = std::max({most, std::abs(components.front()), std::abs(components.back())});
  if (!(most > 0)) most = 1;
  FigureCanvas canvas(Vector2d(-kRange, -1.05 * most), Vector2d(kRange, 1.05 * most));
  canvas.addAxes("standard deviations of a normal distribution", "error, px");
  canvas.addLine(canvas.at(-kRange, -kRange * sigma), canvas.at(kRange, kRange * sigma), "reference");
  std::string dots;
  const std::size_t num_points = std::min(count, kMostPoints);
  double last = 0;
  for (std::size_t k = 0; k < num_points; ++k) {
    // All outer points, because the tails matter.
    const std::size_t from_end = std::min(k, num_points - 1 - k);
    const std::size_t inner =
        from_end < 20 || num_points == count
            ? (k < num_points / 2 ? k : count - num_points + k)
            : static_cast<std::size_t>(
                  std::lround(20 + (static_cast<double>(k) - 20) * (static_cast<double>(count) - 41) /
                                       (static_cast<double>(num_points) - 41)));
    const double quantile = boost::math::quantile(
        boost::math::normal(), (static_cast<double>(inner) + 0.5) / static_cast<double>(count));
    if (std::abs(quantile) > kRange) continue;
    dots += "M" + pointText(canvas.at(quantile, components[inner])) + "h0";
    last = components[inner];
  }
  canvas.addPath(dots, "points");
  return canvas.drawn(
      {.id = "normal-plot",
       .title = "Are the errors normal?",
       .reading = "The dots should lie on the line; ends that turn away from it, upwards on the right and "
                  "downwards on the left, are more large errors than noise explains.",
       .alt = fmt::format(
           "Normal plot of {} errors; the largest drawn is {} px, and three standard deviations are {} px.",
           count, shortNumber(last), shortNumber(3 * sigma))},
      {{"dot point", "errors, sorted"}, {"line reference", "normal distribution"}});
}

}  // namespace alidade
