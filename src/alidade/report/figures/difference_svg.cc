// SPDX-License-Identifier: MIT
#include "alidade/report/figures/difference_svg.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "alidade/core/error.h"
#include "alidade/report/canvas/figure_canvas.h"

namespace alidade {
namespace {

constexpr const char* kBeyondColour = "#c8402a";
constexpr std::string_view kStyle =
    "<style>.beyond{fill:#c8402a}.one{fill:url(#one)}.neither{fill:url(#neither)}"
    ".shaft{stroke:#1c2b45;stroke-linecap:round}</style>\n";
constexpr int kMostCells = 120;  // on a side; more would not be visible
constexpr int kArrows = 18;      // on the longer side

enum class Sight { kBoth, kOne, kNeither };

struct Cell {
  Eigen::Vector2d low;
  Eigen::Vector2d high;
  Eigen::Vector2d pixel;
  Sight sight = Sight::kBoth;
  Eigen::Vector2d difference{0, 0};
};

struct CellGrid {
  int columns = 0;
  int rows = 0;
  int pixels_a_side = 1;  // pixels of the difference's grid per side of a cell
  std::vector<Cell> cells;

  [[nodiscard]] bool has(Sight sight) const {
    return std::any_of(cells.begin(), cells.end(), [sight](const Cell& c) { return c.sight == sight; });
  }
};

// The smallest of 1, 1.5, 2, 3, 5 and 7 times a power of ten that is at least `value`.
double roundAbove(double value) {
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  for (const double step : {1.0, 1.5, 2.0, 3.0, 5.0, 7.0}) {
    if (step * power >= value * (1 - 1e-12)) return step * power;
  }
  return 10 * power;
}

// The upper end of the scale of colours and arrows. Less than a thousandth of a pixel is rounding.
double scaleEnd(const ProjectionDifference& difference) {
  constexpr double kLeastPx = 1e-3;
  return roundAbove(std::max(difference.p95_px, kLeastPx));
}

Sight sightOf(const ComparedCamera& a, const ComparedCamera& b, const ProjectionDifference& difference,
              std::size_t i) {
  if (difference.difference_px[i].allFinite()) return Sight::kBoth;
  const Eigen::Vector2d& pixel = difference.pixels[i];
  const bool is_seen = a.camera->unproject(pixel) || b.camera->unproject(difference.match.inB(pixel));
  return is_seen ? Sight::kOne : Sight::kNeither;
}

// The boundary between the i-th of `places` along a side and the next.
double edgeAfter(const std::vector<double>& places, int i, int length) {
  if (i < 0) return -0.5;
  const auto at = static_cast<std::size_t>(i);
  return at + 1 >= places.size() ? length - 0.5 : 0.5 * (places[at] + places[at + 1]);
}

CellGrid cellsOf(const ComparedCamera& a, const ComparedCamera& b, const ProjectionDifference& difference) {
  const auto at = [&](int row, int column) {
    return static_cast<std::size_t>(row * difference.columns + column);
  };
  std::vector<double> xs;
  std::vector<double> ys;
  for (int column = 0; column < difference.columns; ++column)
    xs.push_back(difference.pixels[at(0, column)].x());
  for (int row = 0; row < difference.rows; ++row) ys.push_back(difference.pixels[at(row, 0)].y());
  CellGrid grid;
  const int n = (std::max(difference.columns, difference.rows) + kMostCells - 1) / kMostCells;
  grid.pixels_a_side = n;
  grid.columns = (difference.columns + n - 1) / n;
  grid.rows = (difference.rows + n - 1) / n;
  for (int top = 0; top < difference.rows; top += n) {
    for (int left = 0; left < difference.columns; left += n) {
      const int bottom = std::min(top + n, difference.rows) - 1;
      const int right = std::min(left + n, difference.columns) - 1;
      Cell cell{.low = {edgeAfter(xs, left - 1, a.size.width), edgeAfter(ys, top - 1, a.size.height)},
                .high = {edgeAfter(xs, right, a.size.width), edgeAfter(ys, bottom, a.size.height)},
                .pixel = difference.pixels[at(top, left)],
                .sight = Sight::kNeither};
      // The pixel with the largest difference represents the cell.
      for (int row = top; row <= bottom; ++row) {
        for (int column = left; column <= right; ++column) {
          const std::size_t i = at(row, column);
          const Sight sight = sightOf(a, b, difference, i);
          const bool is_first = sight < cell.sight || (row == top && column == left);
          const bool is_longer = sight == Sight::kBoth && cell.sight == Sight::kBoth &&
                                 difference.lengthAt(i) > cell.difference.norm();
          if (!is_first && !is_longer) continue;
          cell.sight = sight;
          cell.pixel = difference.pixels[i];
          if (sight == Sight::kBoth) cell.difference = difference.difference_px[i];
        }
      }
      grid.cells.push_back(cell);
    }
  }
  return grid;
}

// Diagonal lines on grey, which is no colour of the scale, for pixels that one camera or both cannot see.
void addPatterns(FigureCanvas& canvas) {
  const auto pattern = [](const char* id, const char* ground, const char* line) {
    return fmt::format(
        "<pattern id=\"{}\" width=\"8\" height=\"8\" patternUnits=\"userSpaceOnUse\" "
        "patternTransform=\"rotate(45)\"><rect width=\"8\" height=\"8\" fill=\"{}\"/><rect width=\"2.4\" "
        "height=\"8\" fill=\"{}\"/></pattern>\n",
        id, ground, line);
  };
  canvas.addRaw(kStyle);
  canvas.addRaw("<defs>\n" + pattern("one", "#f4f4f4", "#9a9a9a") + pattern("neither", "#8a8a8a", "#6e6e6e") +
                "</defs>\n");
}

std::string fillOf(const Cell& cell, double scale_end) {
  if (cell.sight == Sight::kOne) return "url(#one)";
  if (cell.sight == Sight::kNeither) return "url(#neither)";
  const double length = cell.difference.norm();
  return length > scale_end ? kBeyondColour : rampColour(length / scale_end);
}

void addCells(const CellGrid& grid, const ImageSize& size, double scale_end, FigureCanvas& canvas) {
  canvas.open("shape-rendering=\"crispEdges\"");
  // Each overlaps the next slightly, as gaps between rounded edges would show.
  const Eigen::Vector2d border(size.width - 0.5, size.height - 0.5);
  for (const Cell& cell : grid.cells) {
    const Eigen::Vector2d overlap = 0.05 * (cell.high - cell.low);
    const Eigen::Vector2d high = (cell.high + overlap).cwiseMin(border);
    canvas.addRect(canvas.at(cell.low), canvas.at(high), fmt::format("fill=\"{}\"", fillOf(cell, scale_end)));
  }
  canvas.close();
}

// Arrows of the difference, cut to the end of the scale.
std::string arrowsPath(const CellGrid& grid, double scale_end, double longest, const PlotArea& area) {
  const int step = std::max(1, (std::max(grid.columns, grid.rows) + kArrows / 2) / kArrows);
  const double least = 0.003 * area.box.sizes().maxCoeff();
  // Arrows are at equal distances from both borders, and not on them if possible.
  const auto places = [step](int count) {
    const int num_arrows = std::max(1, (count - 1) / step);
    std::vector<int> found;
    for (int i = 0; i < num_arrows; ++i)
      found.push_back((count - 1 - (num_arrows - 1) * step) / 2 + i * step);
    return found;
  };
  std::string d;
  for (const int row : places(grid.rows)) {
    for (const int column : places(grid.columns)) {
      const Cell& cell = grid.cells[static_cast<std::size_t>(row * grid.columns + column)];
      if (cell.sight != Sight::kBoth) continue;
      const double length = cell.difference.norm();
      const double drawn = longest * std::min(1.0, length / scale_end);
      if (drawn >= least) d += arrowPath(area.at(cell.pixel), drawn / length * cell.difference);
    }
  }
  return d;
}

void addWorst(const ProjectionDifference& difference, FigureCanvas& canvas) {
  constexpr double kRoundingPx = 1e-6;
  if (difference.max_px < kRoundingPx) return;
  const Eigen::Vector2d at = canvas.at(difference.worst_pixel);
  canvas.addRing(at, 6);
  const bool is_right = at.x() > canvas.area().box.center().x();
  const bool is_top = at.y() < canvas.area().box.min().y() + 24;
  canvas.addText(at + Eigen::Vector2d(is_right ? -11 : 11, is_top ? 17 : -8),
                 fmt::format("at most {:.4g} px", difference.max_px), is_right ? "end" : "start", "halo");
}

Legend legendOf(const CellGrid& grid, const ProjectionDifference& difference, double scale_end,
                double longest_arrow) {
  const bool goes_beyond = difference.max_px > scale_end;
  Legend legend = {{fmt::format("arrow {:.1f} shaft", longest_arrow),
                    fmt::format("{:g} px{}, from the projection by A to the projection by B", scale_end,
                                goes_beyond ? " or more" : "")}};
  if (goes_beyond) legend.emplace_back("beyond", "more");
  if (grid.has(Sight::kOne)) legend.emplace_back("one", "seen by only one of the cameras");
  if (grid.has(Sight::kNeither)) legend.emplace_back("neither", "seen by neither camera");
  return legend;
}

}  // namespace

Figure differenceDrawing(const ComparedCamera& a, const ComparedCamera& b,
                         const ProjectionDifference& difference, std::span<const std::string> lines) {
  expect(
      difference.columns > 0 && difference.rows > 0 && difference.is_converged && difference.num_compared > 0,
      "a grid of pixels that were compared");
  FigureCanvas canvas(imageArea(a.size, FigureCanvas::kFileWidth), FigureCanvas::kMarks,
                      FigureCanvas::kFileWidth);
  const PlotArea& area = canvas.area();
  const CellGrid grid = cellsOf(a, b, difference);
  const double scale_end = scaleEnd(difference);
  const double longest_arrow = 0.8 * area.box.sizes().maxCoeff() / kArrows;
  addPatterns(canvas);
  addCells(grid, a.size, scale_end, canvas);
  canvas.open("arrows");
  canvas.addPath(arrowsPath(grid, scale_end, longest_arrow, area), "shaft");
  canvas.close();
  canvas.addImageFrame();
  addWorst(difference, canvas);
  canvas.addRamp("0 px", fmt::format("{:g} px", scale_end));
  canvas.addLegend({8, canvas.height()}, legendOf(grid, difference, scale_end, longest_arrow));
  if (grid.pixels_a_side > 1)
    canvas.addCaption(
        fmt::format("Each cell covers {0}x{0} pixels of the grid and shows their largest difference.",
                    grid.pixels_a_side));
  for (const std::string& line : lines) canvas.addCaption(line);
  Figure figure{
      .id = "difference",
      .title = "Difference over the image of A",
      .alt = fmt::format("Difference between the two cameras, up to {:.4g} px.", difference.max_px)};
  figure.svg = canvas.svg(figure.alt);
  return figure;
}

std::string differenceSvg(const ComparedCamera& a, const ComparedCamera& b,
                          const ProjectionDifference& difference, std::span<const std::string> lines) {
  return standaloneSvg(differenceDrawing(a, b, difference, lines).svg);
}

}  // namespace alidade
