// SPDX-License-Identifier: MIT
#include "alidade/camera/correction_field.h"

#include <limits>
#include <string>
#include <utility>

#include <Eigen/LU>

#include "alidade/core/error.h"
#include "alidade/core/number_text.h"
#include "alidade/core/text.h"

namespace alidade {
namespace {

constexpr double kMostPx = 1e6;  // of a coordinate or a displacement

Error refusal(const std::string& found, const std::string& expected, const std::string& next_step = "") {
  return inputError(
      {.where = "correction field", .found = found, .expected = expected, .next_step = next_step});
}

void requireGrid(const CorrectionGrid& grid, std::size_t num_numbers) {
  constexpr int kMost = CorrectionGrid::kMaxCells;
  if (std::min(grid.columns, grid.rows) < 1 || std::max(grid.columns, grid.rows) > kMost) {
    throw refusal(std::to_string(grid.columns) + " by " + std::to_string(grid.rows) + " cells",
                  "1 to " + std::to_string(kMost) + " each way");
  }
  const bool is_placed = grid.origin_px.allFinite() && grid.cell_px.allFinite() &&
                         grid.origin_px.cwiseAbs().maxCoeff() <= kMostPx &&  // false for NaN
                         grid.cell_px.minCoeff() > 1e-3 && grid.cell_px.maxCoeff() <= kMostPx;
  if (!is_placed) throw refusal("a grid without a place", "cells of some pixels in the image plane");
  if (const auto expected = 2 * static_cast<std::size_t>(grid.numPoints()); num_numbers != expected) {
    throw refusal(std::to_string(num_numbers) + " numbers",
                  std::to_string(expected) + ": u and v of (columns + 3) (rows + 3) control points");
  }
}

// The least and the largest of some numbers.
struct Range {
  double min = std::numeric_limits<double>::infinity();
  double max = -std::numeric_limits<double>::infinity();
  void add(double value) {
    min = std::min(min, value);
    max = std::max(max, value);
  }
  [[nodiscard]] double size() const { return std::max(std::abs(min), std::abs(max)); }
};

// The points of a field by column, row and axis.
struct Points {
  const CorrectionGrid& grid;
  const std::vector<double>& numbers;
  [[nodiscard]] double operator()(int column, int row, int axis) const {
    return numbers[static_cast<std::size_t>(2 * (row * grid.pointsAcross() + column) + axis)];
  }
};

// A lower bound of the smallest eigenvalue of the symmetric part of grad D, at most 0, in a cell and, where D
// is constant across the grid's border, beyond. Each derivative lies between the least and the largest
// difference of neighbouring control points.
double leastStretch(const Points& points, int column, int row) {
  std::array<Range, 2> by_x;  // of u and v
  std::array<Range, 2> by_y;
  for (int axis = 0; axis < 2; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    for (int k = 0; k < 4; ++k) {
      for (int step = 0; step < 3; ++step) {
        by_x[a].add(points(column + step + 1, row + k, axis) - points(column + step, row + k, axis));
        by_y[a].add(points(column + k, row + step + 1, axis) - points(column + k, row + step, axis));
      }
    }
  }
  const Eigen::Vector2d& cell = points.grid.cell_px;
  for (Range& range : by_x) range = {range.min / cell.x(), range.max / cell.x()};
  for (Range& range : by_y) range = {range.min / cell.y(), range.max / cell.y()};
  // What the derivatives across have in common; beyond the border, one of them is 0.
  const Range sum{by_x[1].min + by_y[0].min, by_x[1].max + by_y[0].max};
  const double across = 0.5 * std::max({sum.size(), by_x[1].size(), by_y[0].size()});
  return std::min({by_x[0].min, by_y[1].min, 0.0}) - across;
}

constexpr double kNearlyFolded = -0.99;

// The control points of the same field on cells of half the width and height, which lie nearer to it (Lane
// and Riesenfeld 1980, A theoretical development for the computer generation and display of piecewise
// polynomial surfaces, PAMI 2(1)).
std::vector<double> halved(CorrectionGrid& grid, const std::vector<double>& points) {
  const CorrectionGrid from = grid;
  const Points old{from, points};
  grid.columns *= 2;
  grid.rows *= 2;
  grid.cell_px /= 2;
  const auto between = [](int k, const auto& at) {  // an edge's middle, or a corner
    const int i = (k + 1) / 2;
    return k % 2 == 0 ? 0.5 * (at(i) + at(i + 1)) : (at(i - 1) + 6 * at(i) + at(i + 1)) / 8;
  };
  std::vector<double> fine;
  fine.reserve(2 * static_cast<std::size_t>(grid.numPoints()));
  for (int row = 0; row < grid.rows + 3; ++row) {
    for (int column = 0; column < grid.pointsAcross(); ++column) {
      for (int axis = 0; axis < 2; ++axis) {
        fine.push_back(
            between(row, [&](int j) { return between(column, [&](int i) { return old(i, j, axis); }); }));
      }
    }
  }
  return fine;
}

// leastStretch() of each cell of a grid, row by row.
std::vector<double> leastStretches(const CorrectionGrid& grid, const std::vector<double>& points) {
  constexpr int kParts = 4;  // of a cell, along and across
  CorrectionGrid fine = grid;
  std::vector<double> fine_points = halved(fine, points);
  fine_points = halved(fine, fine_points);
  std::vector<double> least(static_cast<std::size_t>(grid.columns * grid.rows));
  for (int row = 0; row < fine.rows; ++row) {
    for (int column = 0; column < fine.columns; ++column) {
      double& of_cell = least[static_cast<std::size_t>(row / kParts * grid.columns + column / kParts)];
      const double of_part = leastStretch({fine, fine_points}, column, row);
      if (!(of_part >= of_cell)) of_cell = of_part;
    }
  }
  return least;
}

}  // namespace

CorrectionGrid CorrectionGrid::over(ImageSize size, int columns, int rows) {
  return {.columns = columns,
          .rows = rows,
          .origin_px = {-0.5, -0.5},
          .cell_px = {static_cast<double>(size.width) / columns, static_cast<double>(size.height) / rows}};
}

CorrectionField::CorrectionField(const CorrectionGrid& grid, std::vector<double> points)
    : grid_(grid), points_(std::move(points)) {
  requireGrid(grid_, points_.size());
  for (const double number : points_) {
    if (!(std::abs(number) <= kMostPx)) throw refusal(exactText(number), "pixels, from -1e6 to 1e6");
  }
  const double least = std::ranges::min(leastStretches(grid_, points_));
  if (!(least > kNearlyFolded)) {
    throw refusal("neighbouring pixels that may change places: a gradient of " + numberText("%.3g", least),
                  "a smooth field, with gradients above -0.99",
                  "check the numbers, or leave the correction out");
  }
}

CorrectionField CorrectionField::soundPart(const CorrectionGrid& grid, const std::vector<double>& points,
                                           const Eigen::Vector2d& about) {
  requireGrid(grid, points.size());
  const std::vector<double> least = leastStretches(grid, points);
  const auto isSound = [&](const Eigen::Array2i& low, const Eigen::Array2i& high) {
    for (int row = low.y(); row <= high.y(); ++row) {
      for (int column = low.x(); column <= high.x(); ++column) {
        if (!(least[static_cast<std::size_t>(row * grid.columns + column)] > kNearlyFolded)) return false;
      }
    }
    return true;
  };
  const Eigen::Array2i last(grid.columns - 1, grid.rows - 1);
  Eigen::Array2i low =
      ((about - grid.origin_px).array() / grid.cell_px.array()).max(0).min(1e3).cast<int>().min(last);
  Eigen::Array2i high = low;
  bool has_grown = isSound(low, high);
  while (has_grown) {
    has_grown = false;
    for (int axis = 0; axis < 2; ++axis) {
      for (const int step : {-1, 1}) {
        int& end = (step < 0 ? low : high)(axis);
        if (end + step < 0 || end + step > last(axis)) continue;
        Eigen::Array2i from = low;
        Eigen::Array2i to = high;
        from(axis) = to(axis) = end + step;
        if (!isSound(from, to)) continue;
        end += step;
        has_grown = true;
      }
    }
  }
  CorrectionGrid part = grid;
  part.is_bounded = true;
  part.columns = high.x() - low.x() + 1;
  part.rows = high.y() - low.y() + 1;
  part.origin_px += grid.cell_px.cwiseProduct(low.cast<double>().matrix());
  std::vector<double> of_part;
  for (int row = 0; row < part.rows + 3; ++row) {
    const auto at = points.begin() + 2 * ((low.y() + row) * grid.pointsAcross() + low.x());
    of_part.insert(of_part.end(), at, at + 2 * part.pointsAcross());
  }
  return {part, std::move(of_part)};
}

Eigen::Vector2d CorrectionField::at(const Eigen::Vector2d& pixel, Eigen::Matrix2d* gradient) const {
  const CorrectionGrid::Patch patch = grid_.patchAt(pixel);
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  Eigen::Matrix2d slopes = Eigen::Matrix2d::Zero();
  for (std::size_t j = 0; j < 4; ++j) {
    const double* row =
        points_.data() + 2 * (patch.first + j * static_cast<std::size_t>(grid_.pointsAcross()));
    Eigen::Vector2d along = Eigen::Vector2d::Zero();
    Eigen::Vector2d slope = Eigen::Vector2d::Zero();
    for (std::size_t i = 0; i < 4; ++i) {
      const Eigen::Vector2d point(row[2 * i], row[2 * i + 1]);
      along += patch.x[i] * point;
      slope += patch.dx[i] * point;
    }
    sum += patch.y[j] * along;
    slopes.col(0) += patch.y[j] * slope;
    slopes.col(1) += patch.dy[j] * along;
  }
  if (gradient != nullptr) *gradient = slopes;
  return sum;
}

std::optional<Eigen::Vector2d> CorrectionField::undisplaced(const Eigen::Vector2d& pixel) const {
  if (!pixel.allFinite()) return std::nullopt;
  // Newton's method; the displacement is monotone, so a short enough step along its direction always helps.
  constexpr int kSteps = 100;
  constexpr double kExactPx = 1e-11;
  Eigen::Matrix2d gradient;
  Eigen::Vector2d from = pixel - at(pixel);
  Eigen::Vector2d off = from + at(from, &gradient) - pixel;
  const double enough = kExactPx * std::max(1.0, pixel.norm() / 1e3);
  for (int i = 0; i < kSteps && off.norm() > enough; ++i) {
    const Eigen::Vector2d step = (Eigen::Matrix2d::Identity() + gradient).inverse() * off;
    double share = 1;
    Eigen::Vector2d next_off = off;
    Eigen::Vector2d next = from;
    Eigen::Matrix2d next_gradient = gradient;
    for (; share > 1e-6; share /= 2) {
      next = from - share * step;
      next_off = next + at(next, &next_gradient) - pixel;
      if (next_off.squaredNorm() < off.squaredNorm()) break;
    }
    if (!(share > 1e-6)) break;  // rounding
    from = next;
    off = next_off;
    gradient = next_gradient;
  }
  constexpr double kSamePx = 1e-6;
  if (!(off.norm() <= kSamePx) || !grid_.has(from)) return std::nullopt;
  return from;
}

double CorrectionField::largest() const {
  double squared = 0;
  for (std::size_t i = 0; i < points_.size(); i += 2)
    squared = std::max(squared, points_[i] * points_[i] + points_[i + 1] * points_[i + 1]);
  return std::sqrt(squared);
}

CorrectionField CorrectionField::mapped(const Eigen::Matrix2d& A, const Eigen::Vector2d& b) const {
  const bool is_swapped = A(0, 0) == 0;
  const Eigen::Vector2d end =
      grid_.origin_px + grid_.cell_px.cwiseProduct(Eigen::Vector2d(grid_.columns, grid_.rows));
  CorrectionGrid grid = grid_;
  grid.columns = is_swapped ? grid_.rows : grid_.columns;
  grid.rows = is_swapped ? grid_.columns : grid_.rows;
  grid.origin_px = (A * grid_.origin_px + b).cwiseMin(A * end + b);
  grid.cell_px = A.cwiseAbs() * grid_.cell_px;
  std::vector<double> points(points_.size());
  for (int j = 0; j < grid_.rows + 3; ++j) {
    for (int i = 0; i < grid_.columns + 3; ++i) {
      const Eigen::Vector2d place =
          grid_.origin_px + grid_.cell_px.cwiseProduct(Eigen::Vector2d(i - 1, j - 1));
      const Eigen::Vector2d at = (A * place + b - grid.origin_px).cwiseQuotient(grid.cell_px);
      const auto from = static_cast<std::size_t>(2 * (j * grid_.pointsAcross() + i));
      const auto to = static_cast<std::size_t>(
          2 * ((std::lround(at.y()) + 1) * grid.pointsAcross() + std::lround(at.x()) + 1));
      const Eigen::Vector2d moved = A * Eigen::Vector2d(points_[from], points_[from + 1]);
      points[to] = moved.x();
      points[to + 1] = moved.y();
    }
  }
  return {grid, std::move(points)};
}

}  // namespace alidade
