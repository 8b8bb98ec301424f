// SPDX-License-Identifier: MIT
#include "alidade/detect/board/circle_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Eigenvalues>

#include "alidade/core/median.h"
#include "alidade/detect/board/one_colour.h"

namespace alidade {

using Eigen::Vector2d;

CircleSearch::CircleSearch(const GrayImage& image, const Board& board, const GridPlacement& placement)
    : image_(image), board_(board), found_(static_cast<std::size_t>(board.numCorners())) {
  constexpr double kSafe = 0.8;  // share of the way to the midpoint between neighbours
  reach_ = 1 + kSafe * (0.5 * board.spacing() / board.discRadius() - 1);
  for (const auto& [id, blob] : placement.blobs) fitAt(id, blob.pixel, blob.shape);
  dropOdd();
  // Circles that were not blobs of their own, for example at the edge of a shadow, are searched between their
  // neighbours.
  for (int id = 0; id < board.numCorners(); ++id) {
    if (at(id)) continue;
    if (const auto guess = between(id)) fitAt(id, guess->pixel, guess->shape);
  }
  dropOdd();
}

const std::optional<DiscFit>& CircleSearch::at(int id) const {
  static const std::optional<DiscFit> none;
  return id < 0 ? none : found_[static_cast<std::size_t>(id)];
}

// Ids of neighbours on opposite sides; -1 beyond the border.
std::array<std::pair<int, int>, 2> CircleSearch::oppositePairs(int id) const {
  const int columns = board_.columns();
  const int column = id % columns;
  const int row = id / columns;
  const auto idAt = [&](int c, int r) {
    return c >= 0 && c < columns && r >= 0 && r < board_.rows() ? r * columns + c : -1;
  };
  // Circles of an asymmetric grid are aligned again two rows apart.
  const int rows_apart = board_.pattern() == BoardPattern::kStaggeredDiscs ? 2 : 1;
  return {{{idAt(column - 1, row), idAt(column + 1, row)},
           {idAt(column, row - rows_apart), idAt(column, row + rows_apart)}}};
}

// The mean of opposite neighbours, for each of the two directions that has a pair.
std::optional<DiscFit> CircleSearch::between(int id) const {
  DiscFit mean{
      .pixel = Vector2d::Zero(), .shape = Eigen::Matrix2d::Zero(), .covariance = Eigen::Matrix2d::Zero()};
  int count = 0;
  for (const auto& [before, after] : oppositePairs(id)) {
    if (!at(before) || !at(after)) continue;
    mean.pixel += 0.5 * (at(before)->pixel + at(after)->pixel);
    mean.shape += 0.5 * (at(before)->shape + at(after)->shape);
    ++count;
  }
  if (count == 0) return std::nullopt;
  mean.pixel /= count;
  mean.shape /= count;
  return mean;
}

// In the frame where neighbours have the distances of the board, a disc must be a circle, because both have
// the same perspective.
std::optional<SeenProportions> CircleSearch::proportions() const {
  std::vector<double> along_rows;
  std::vector<double> along_columns;
  std::vector<double> diameters_px;
  for (int id = 0; id < board_.numCorners(); ++id) {
    if (!at(id)) continue;
    Eigen::Matrix2d pixels;
    Eigen::Matrix2d places;
    int count = 0;
    for (const auto& [before, after] : oppositePairs(id)) {
      if (!at(before) || !at(after)) continue;
      pixels.col(count) = at(after)->pixel - at(before)->pixel;
      places.col(count) = (board_.corner(after) - board_.corner(before)).head<2>();
      ++count;
    }
    if (count < 2) continue;
    const Eigen::Matrix2d pixels_by_place = pixels * places.inverse();
    const Eigen::Matrix2d circle = pixels_by_place.transpose() * at(id)->shape * pixels_by_place;
    along_rows.push_back(1 / std::sqrt(circle(0, 0)));
    along_columns.push_back(1 / std::sqrt(circle(1, 1)));
    diameters_px.push_back(2 * std::pow(at(id)->shape.determinant(), -0.25));
  }
  if (along_rows.empty()) return std::nullopt;
  const double x = medianOf(std::move(along_rows));
  const double y = medianOf(std::move(along_columns));
  return SeenProportions{.diameter_m = 2 * std::sqrt(x * y),
                         .rows_apart = x / y,
                         .diameter_px = medianOf(std::move(diameters_px))};
}

// The distance to the nearest neighbour; NaN without one.
double CircleSearch::stepAt(int id) const {
  double least = std::numeric_limits<double>::quiet_NaN();
  for (const auto& pair : oppositePairs(id)) {
    for (const int other : {pair.first, pair.second}) {
      if (at(other)) least = std::fmin(least, (at(other)->pixel - at(id)->pixel).norm());
    }
  }
  return least;
}

void CircleSearch::fitAt(int id, const Vector2d& pixel, const Eigen::Matrix2d& shape) {
  found_[static_cast<std::size_t>(id)] = fitDisc(image_, {.pixel = pixel, .shape = shape, .reach = reach_});
}

// Drops circles of the other colour, and those whose position or shape disagrees with their neighbours.
void CircleSearch::dropOdd() {
  keepOneColour(found_, [](std::size_t, const DiscFit& disc) { return disc.contrast > 0; });
  // Shares of the step and of the shape; perspective and the lens cause smaller changes between neighbours.
  constexpr double kMostOff = 0.25;
  constexpr double kMostReshaped = 0.4;
  std::vector<int> misplaced;
  for (int id = 0; id < board_.numCorners(); ++id) {
    const auto expected = at(id) ? between(id) : std::nullopt;
    if (!expected) continue;
    const bool is_off = (expected->pixel - at(id)->pixel).norm() > kMostOff * stepAt(id);
    const bool is_other = (expected->shape - at(id)->shape).norm() > kMostReshaped * expected->shape.norm();
    if (is_off || is_other) misplaced.push_back(id);
  }
  for (const int id : misplaced) found_[static_cast<std::size_t>(id)].reset();
}

ViewMeasures CircleSearch::measures() const {
  std::vector<double> blurs;
  std::vector<double> spacings;
  std::vector<double> tilts;
  double area = 0;
  const double cell_in_discs = board_.span().prod() / board_.numCorners() /
                               (std::numbers::pi * board_.discRadius() * board_.discRadius());
  for (std::size_t i = 0; i < found_.size(); ++i) {
    const auto& disc = found_[i];
    if (!disc) continue;
    blurs.push_back(disc->blur_px);
    const double step = stepAt(static_cast<int>(i));
    if (std::isfinite(step)) spacings.push_back(step);
    const Vector2d values = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(disc->shape).eigenvalues();
    tilts.push_back(std::acos(std::sqrt(values(0) / values(1))));
    area += std::numbers::pi / std::sqrt(values(0) * values(1)) * cell_in_discs;
  }
  return {.blur_px = medianOf(std::move(blurs)),
          .spacing_px = spacings.empty() ? std::numeric_limits<double>::quiet_NaN() : medianOf(spacings),
          .area_share = std::min(1.0, area / (static_cast<double>(image_.size.width) * image_.size.height)),
          .tilt_deg = medianOf(std::move(tilts)) * 180 / std::numbers::pi};
}

}  // namespace alidade
