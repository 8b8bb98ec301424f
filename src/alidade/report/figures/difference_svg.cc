// SPDX-License-Identifier: MIT
#include "alidade/report/figures/difference_svg.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include <fmt/format.h>

#include "alidade/core/error.h"
#include "alidade/report/canvas/svg_canvas.h"

namespace alidade {
namespace {

constexpr const char* kBeyondColour = "#c8402a";
constexpr const char* kArrowColour = "#1c2b45";
constexpr const char* kWorstColour = "#7a0016";
constexpr int kMostCells = 120;  // on a side: more would be seen by nobody
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
  int pixels_a_side = 1;  // of the difference's grid, for one cell
  std::vector<Cell> cells;

  [[nodiscard]] bool has(Sight sight) const {
    return std::any_of(cells.begin(), cells.end(), [sight](const Cell& c) { return c.sight == sight; });
  }
};

// The least of 1, 1.5, 2, 3, 5 and 7 times a power of ten that is not below `value`.
double roundAbove(double value) {
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  for (const double step : {1.0, 1.5, 2.0, 3.0, 5.0, 7.0}) {
    if (step * power >= value * (1 - 1e-12)) return step * power;
  }
  return 10 * power;
}

// What colours and arrows end at. Below a thousandth of a pixel there is nothing but rounding to see.
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

// Where the i-th of `places` along a side ends and the next begins.
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
      // Of several pixels the one that differs most stands for all.
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

// Diagonal lines on grey: both what one camera sees and what neither does are no colour of the scale.
void addPatterns(SvgCanvas& drawing) {
  const auto pattern = [&](const char* id, const char* ground, const char* line) {
    const double step = 1.2 * drawing.unit();
    drawing.addText(
        fmt::format("<pattern id=\"{}\" width=\"{:.2f}\" height=\"{:.2f}\" patternUnits=\"userSpaceOnUse\" "
                    "patternTransform=\"rotate(45)\"><rect width=\"{:.2f}\" height=\"{:.2f}\" "
                    "fill=\"{}\"/><rect width=\"{:.2f}\" height=\"{:.2f}\" fill=\"{}\"/></pattern>\n",
                    id, step, step, step, step, ground, 0.3 * step, step, line));
  };
  drawing.addText("<defs>\n");
  pattern("one", "#f4f4f4", "#9a9a9a");
  pattern("neither", "#8a8a8a", "#6e6e6e");
  drawing.addText("</defs>\n");
}

std::string fillOf(const Cell& cell, double scale_end) {
  if (cell.sight == Sight::kOne) return "url(#one)";
  if (cell.sight == Sight::kNeither) return "url(#neither)";
  const double length = cell.difference.norm();
  return length > scale_end ? kBeyondColour : rampColour(length / scale_end);
}

void addArrow(SvgCanvas& drawing, const Eigen::Vector2d& from, const Eigen::Vector2d& along) {
  const double length = along.norm();
  const Eigen::Vector2d to = from + along;
  drawing.addLine({from, to}, kArrowColour, 0.22);
  const double head = std::min(1.1 * drawing.unit(), 0.4 * length);
  const Eigen::Vector2d back = head / length * along;
  const Eigen::Vector2d side(-0.5 * back.y(), 0.5 * back.x());
  drawing.addLine({to - back + side, to, to - back - side}, kArrowColour, 0.22);
}

// The difference's own length, cut where the scale ends, as an arrow of the drawing.
void addArrows(SvgCanvas& drawing, const CellGrid& grid, double scale_end, double longest) {
  const int step = std::max(1, (std::max(grid.columns, grid.rows) + kArrows / 2) / kArrows);
  // As far from one border as from the other, and not on it where there is a choice.
  const auto places = [step](int count) {
    const int num_arrows = std::max(1, (count - 1) / step);
    std::vector<int> found;
    for (int i = 0; i < num_arrows; ++i)
      found.push_back((count - 1 - (num_arrows - 1) * step) / 2 + i * step);
    return found;
  };
  drawing.addText("<g stroke-linecap=\"round\">\n");
  for (const int row : places(grid.rows)) {
    for (const int column : places(grid.columns)) {
      const Cell& cell = grid.cells[static_cast<std::size_t>(row * grid.columns + column)];
      if (cell.sight != Sight::kBoth) continue;
      const double length = cell.difference.norm();
      const double drawn = longest * std::min(1.0, length / scale_end);
      if (drawn < 0.3 * drawing.unit()) continue;
      addArrow(drawing, cell.pixel, drawn / length * cell.difference);
    }
  }
  drawing.addText("</g>\n");
}

void addTicks(SvgCanvas& drawing) {
  const ImageSize size = drawing.size();
  const double unit = drawing.unit();
  const int step = static_cast<int>(roundAbove(std::max(1.0, std::max(size.width, size.height) / 7.0)));
  for (int x = 0; x < size.width; x += step) {
    const auto at = static_cast<double>(x);
    drawing.addLine({{at, -0.5}, {at, -0.5 - 0.7 * unit}}, "#333", 0.2);
    drawing.addLabel({at, -0.5 - 1.2 * unit}, "#333", std::to_string(x));
  }
  for (int y = 0; y < size.height; y += step) {
    const auto at = static_cast<double>(y);
    drawing.addLine({{-0.5, at}, {-0.5 - 0.7 * unit, at}}, "#333", 0.2);
    drawing.addLabel({-0.5 - 1.2 * unit, at + 0.75 * unit}, "#333", std::to_string(y), "end");
  }
}

void addWorst(SvgCanvas& drawing, const ProjectionDifference& difference) {
  constexpr double kRoundingPx = 1e-6;
  if (difference.max_px < kRoundingPx) return;
  const double unit = drawing.unit();
  const Eigen::Vector2d& at = difference.worst_pixel;
  drawing.addRing(at, kWorstColour, 1.2);
  const bool is_right = at.x() > 0.5 * drawing.size().width;
  const bool is_top = at.y() < 4 * unit;
  drawing.addLabel(at + Eigen::Vector2d(is_right ? -2 * unit : 2 * unit, is_top ? 3 * unit : -1.5 * unit),
                   kWorstColour, fmt::format("at most {:.4g} px", difference.max_px),
                   is_right ? "end" : "start");
}

void addLegend(SvgCanvas& drawing, const CellGrid& grid, const ProjectionDifference& difference,
               double scale_end, double longest_arrow) {
  const double unit = drawing.unit();
  const auto nextRow = [&] { return drawing.takeRow(3) - 2 * unit; };
  const auto addText = [&](double x, double top, const std::string& text) {
    drawing.addLabel({x, top + 1.7 * unit}, "#111", text, "start");
  };
  const double top = nextRow();
  const double end = drawing.addRamp(top, "0 px", fmt::format("{:g} px", scale_end));
  const double x = end + unit + 8 * unit;
  const bool goes_beyond = difference.max_px > scale_end;
  if (goes_beyond) {
    drawing.addRect({x, top}, {x + 3 * unit, top + 2 * unit}, kBeyondColour);
    addText(x + 4 * unit, top, "more");
  }
  const double arrow_top = nextRow();
  addArrow(drawing, {8 * unit - longest_arrow, arrow_top + unit}, {longest_arrow, 0});
  addText(9 * unit, arrow_top,
          fmt::format("{:g} px{}, from the projection by A to the projection by B", scale_end,
                      goes_beyond ? " or more" : ""));
  const auto addBox = [&](const char* fill, const char* text) {
    const double box_top = nextRow();
    drawing.addRect({4 * unit, box_top}, {8 * unit, box_top + 2 * unit}, fill);
    addText(9 * unit, box_top, text);
  };
  if (grid.has(Sight::kOne)) addBox("url(#one)", "seen by only one of the cameras");
  if (grid.has(Sight::kNeither)) addBox("url(#neither)", "seen by neither camera");
  if (grid.pixels_a_side > 1)
    drawing.addCaption(
        fmt::format("Each cell covers {0}x{0} pixels of the grid and shows their largest difference.",
                    grid.pixels_a_side));
}

}  // namespace

std::string differenceSvg(const ComparedCamera& a, const ComparedCamera& b,
                          const ProjectionDifference& difference, std::span<const std::string> lines) {
  expect(
      difference.columns > 0 && difference.rows > 0 && difference.is_converged && difference.num_compared > 0,
      "a grid of pixels that were compared");
  constexpr double kMargin = 7;
  SvgCanvas drawing(a.size, kMargin);
  const CellGrid grid = cellsOf(a, b, difference);
  const double scale_end = scaleEnd(difference);
  const double longest_arrow = 0.8 * 100 / kArrows * drawing.unit();
  addPatterns(drawing);
  drawing.addText("<g shape-rendering=\"crispEdges\">\n");
  // Each lies a little under the next, or the gaps between rounded edges would show.
  const Eigen::Vector2d border(a.size.width - 0.5, a.size.height - 0.5);
  for (const Cell& cell : grid.cells) {
    const Eigen::Vector2d overlap = 0.05 * (cell.high - cell.low);
    drawing.addRect(cell.low, (cell.high + overlap).cwiseMin(border), fillOf(cell, scale_end));
  }
  drawing.addText("</g>\n");
  drawing.addFrame();
  addArrows(drawing, grid, scale_end, longest_arrow);
  addTicks(drawing);
  addWorst(drawing, difference);
  addLegend(drawing, grid, difference, scale_end, longest_arrow);
  for (const std::string& line : lines) drawing.addCaption(line);
  return drawing.text();
}

}  // namespace alidade
