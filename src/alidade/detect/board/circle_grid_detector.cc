// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <type_traits>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <Eigen/LU>

#include "alidade/core/error.h"
#include "alidade/core/median.h"
#include "alidade/detect/board/disc_lattice.h"
#include "alidade/detect/board/find_board.h"
#include "alidade/detect/board/one_colour.h"
#include "alidade/detect/corner/disc_fit.h"
#include "alidade/geometry/symmetric_eigen.h"
#include "alidade/target/board.h"

namespace alidade {
namespace {

using Eigen::Vector2d;

// The proportions of a grid from the shapes of its discs, which no perspective changes.
struct SeenProportions {
  double diameter_m = 0;  // if the spacing of the board is as stated
  double rows_apart = 1;  // distance of rows over that of columns, relative to the board
  double diameter_px = 0;
};

// The circles of a placed grid: fitted to blobs, or searched between the found ones if there is no blob.
class CircleSearch {
 public:
  // `image` and `board` must outlive it.
  CircleSearch(const GrayImage& image, const Board& board, const GridPlacement& placement)
      : image_(image), board_(board), found_(static_cast<std::size_t>(board.numCorners())) {
    constexpr double kSafe = 0.8;  // share of the way to the midpoint between neighbours
    reach_ = 1 + kSafe * (0.5 * board.spacing() / board.discRadius() - 1);
    for (const auto& [id, blob] : placement.blobs) fitAt(id, blob.pixel, blob.shape);
    dropOdd();
    // Circles that were not blobs of their own, for example at the edge of a shadow, are searched between
    // their neighbours.
    for (int id = 0; id < board.numCorners(); ++id) {
      if (at(id)) continue;
      if (const auto guess = between(id)) fitAt(id, guess->pixel, guess->shape);
    }
    dropOdd();
  }

  [[nodiscard]] const std::vector<std::optional<DiscFit>>& found() const { return found_; }

  // In the frame where neighbours have the distances of the board, a disc must be a circle, because both have
  // the same perspective.
  [[nodiscard]] std::optional<SeenProportions> proportions() const {
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

  [[nodiscard]] ViewMeasures measures() const {
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
      const Vector2d values = SymmetricEigen(disc->shape).eigenvalues();
      tilts.push_back(std::acos(std::sqrt(values(0) / values(1))));
      area += std::numbers::pi / std::sqrt(values(0) * values(1)) * cell_in_discs;
    }
    return medianMeasures(std::move(blurs), std::move(spacings), std::move(tilts), area, image_.size);
  }

 private:
  [[nodiscard]] const std::optional<DiscFit>& at(int id) const {
    static const std::optional<DiscFit> none;
    return id < 0 ? none : found_[static_cast<std::size_t>(id)];
  }

  // Ids of neighbours on opposite sides; -1 beyond the border.
  [[nodiscard]] std::array<std::pair<int, int>, 2> oppositePairs(int id) const {
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
  [[nodiscard]] std::optional<DiscFit> between(int id) const {
    DiscFit mean{.pixel = Vector2d::Zero(), .shape = Eigen::Matrix2d::Zero()};
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

  // The distance to the nearest neighbour; NaN without one.
  [[nodiscard]] double stepAt(int id) const {
    double least = std::numeric_limits<double>::quiet_NaN();
    for (const auto& pair : oppositePairs(id)) {
      for (const int other : {pair.first, pair.second}) {
        if (at(other)) least = std::fmin(least, (at(other)->pixel - at(id)->pixel).norm());
      }
    }
    return least;
  }

  void fitAt(int id, const Vector2d& pixel, const Eigen::Matrix2d& shape) {
    found_[static_cast<std::size_t>(id)] = fitDisc(image_, {.pixel = pixel, .shape = shape, .reach = reach_});
  }

  // Drops circles of the other colour, and those whose position or shape disagrees with their neighbours.
  void dropOdd() {
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

  const GrayImage& image_;
  const Board& board_;
  double reach_ = 0;
  std::vector<std::optional<DiscFit>> found_;
};

struct SeenGrids {
  std::vector<std::vector<GridPlacement>> of_lattices;  // of the largest lattice first
  int num_lattices = 0;
};

// Searches dark circles and bright ones, by comparison with a wide and a close neighbourhood, until
// `is_wanted` is true for a grid.
template <class F>
SeenGrids lookForGrids(const GrayImage& image, const F& is_wanted) {
  SeenGrids best;
  for (const bool is_bright : {false, true}) {
    for (const double window_share : {0.25, 0.08}) {
      SeenGrids seen;
      for (const DiscLattice& lattice : findLattices(image, is_bright, window_share)) {
        ++seen.num_lattices;
        auto placements = gridPlacementsOf(lattice);
        if (!placements.empty()) seen.of_lattices.push_back(std::move(placements));
      }
      if (is_wanted(seen)) return seen;
      if (best.of_lattices.empty()) best = std::move(seen);
    }
  }
  return best;
}

Detection refuseOther(const SeenGrids& seen, const CircleCounts& asked) {
  if (seen.of_lattices.empty() && seen.num_lattices > 0)
    return {.reason = DetectionReason::kUnplaced,
            .detail = "circles of a grid, but not all of its outer lines"};
  if (seen.of_lattices.empty())
    return {.reason = DetectionReason::kNoBoard, .detail = "no grid of circles was found"};
  const CircleCounts& counts = seen.of_lattices.front().front().counts;
  const bool is_part = std::max(counts.columns, counts.rows) <= std::max(asked.columns, asked.rows) &&
                       std::min(counts.columns, counts.rows) <= std::min(asked.columns, asked.rows) &&
                       counts.is_asymmetric == asked.is_asymmetric;
  return {.reason = is_part ? DetectionReason::kUnplaced : DetectionReason::kOtherBoard,
          .detail = fmt::format("{}, not {}{}", countsText(counts), countsText(asked),
                                is_part ? "; all of the outer lines must be seen" : "")};
}

constexpr double kMostStretch = 1.2;  // a print may be slightly out of proportion

bool isStretched(const SeenProportions& seen) {
  return std::max(seen.rows_apart, 1 / seen.rows_apart) > kMostStretch;
}

// Describes how the proportions of the circles differ from those of the board; empty if they agree. Otherwise
// the camera would be wrong: the distance between a disc's centroid and the image of its centre is
// proportional to the square of the diameter.
std::string otherProportion(const SeenProportions& seen, const Board& board) {
  constexpr double kMostOff = 0.15;
  constexpr double kMostOffPx = 1;  // for small discs, whose size print and blur change by more
  if (isStretched(seen)) {
    return fmt::format(
        "rows of circles are {:.2f} times as far apart as on {}, beside the distance of columns",
        seen.rows_apart, board.spec());
  }
  const double expected_m = 2 * board.discRadius();
  const double most_off = std::max(kMostOff, kMostOffPx / seen.diameter_px);
  if (std::abs(seen.diameter_m / expected_m - 1) <= most_off) return {};
  return fmt::format("circles with diameters of {:.2f} of their neighbours' distance, not {:.2f} as on {}",
                     seen.diameter_m / board.spacing(), expected_m / board.spacing(), board.spec());
}

template <class Kind>
Detection findCircles(const GrayImage& image, const Kind& kind) {
  expect(!image.empty(), "an image with pixels");
  const Board board(kind);
  const CircleCounts asked{.is_asymmetric = std::is_same_v<Kind, AsymmetricCircleGrid>,
                           .columns = kind.columns,
                           .rows = kind.rows};
  const auto isAsked = [&](const std::vector<GridPlacement>& of) {
    return chosenPlacement(of, asked) != nullptr;
  };
  const SeenGrids seen = lookForGrids(
      image, [&](const SeenGrids& grids) { return std::ranges::any_of(grids.of_lattices, isAsked); });
  const auto num_matches = std::ranges::count_if(seen.of_lattices, isAsked);
  if (num_matches == 0) return refuseOther(seen, asked);
  if (num_matches > 1) {
    return {.reason = DetectionReason::kSeveralBoards,
            .detail = fmt::format("{} grids of {}", num_matches, countsText(asked))};
  }
  const CircleSearch search(image, board,
                            *chosenPlacement(*std::ranges::find_if(seen.of_lattices, isAsked), asked));
  Detection detection;
  for (std::size_t i = 0; i < search.found().size(); ++i) {
    if (const auto& disc = search.found()[i])
      detection.corners.push_back(
          {.id = static_cast<int>(i), .pixel = disc->pixel, .sigma_px = disc->sigma_px});
  }
  const std::size_t num_found = detection.corners.size();
  if (2 * num_found < search.found().size()) {
    return detection.withdraw(
        DetectionReason::kBlurred,
        fmt::format("a grid of circles, of which only {} are clear enough to be located", num_found));
  }
  const auto proportions = search.proportions();
  if (const std::string other = proportions ? otherProportion(*proportions, board) : ""; !other.empty())
    return detection.withdraw(DetectionReason::kOtherBoard, other);
  detection.measures = search.measures();
  detection.describeMissing(board.numCorners(), "circles", {}, image.size);
  return detection;
}

// A board with spacing 1 and discs that leave little room between them.
Board unitBoard(const CircleCounts& counts) {
  constexpr double kLargest = 0.84;  // share of the distance between neighbours
  if (!counts.is_asymmetric) {
    return CircleGrid{.columns = counts.columns, .rows = counts.rows, .spacing_m = 1, .diameter_m = kLargest};
  }
  return AsymmetricCircleGrid{.columns = counts.columns,
                              .rows = counts.rows,
                              .spacing_m = 1,
                              .diameter_m = kLargest * std::numbers::sqrt2};
}

}  // namespace

Detection findBoard(const GrayImage& image, const CircleGrid& board) {
  return findCircles(image, board);
}

Detection findBoard(const GrayImage& image, const AsymmetricCircleGrid& board) {
  return findCircles(image, board);
}

std::optional<SeenCircles> seenCircleGrid(const GrayImage& image) {
  constexpr double kWhole = 0.95;
  const auto wholeGrid = [&](const std::vector<GridPlacement>& of) -> std::optional<SeenCircles> {
    const GridPlacement& fullest = of.front();
    const Board board = unitBoard(fullest.counts);
    const CircleSearch search(image, board, fullest);
    const auto num_discs =
        std::ranges::count_if(search.found(), [](const auto& disc) { return disc.has_value(); });
    if (static_cast<double>(num_discs) < kWhole * board.numCorners()) return std::nullopt;
    const auto proportions = search.proportions();
    if (proportions && isStretched(*proportions)) return std::nullopt;
    SeenCircles seen{.counts = fullest.counts, .diameter = {}};
    if (proportions) seen.diameter = proportions->diameter_m;
    return seen;
  };
  std::optional<SeenCircles> whole;
  lookForGrids(image, [&](const SeenGrids& grids) {
    return std::ranges::any_of(grids.of_lattices, [&](const auto& of) {
      whole = wholeGrid(of);
      return whole.has_value();
    });
  });
  if (whole && !whole->counts.is_asymmetric && whole->counts.columns < whole->counts.rows)
    std::swap(whole->counts.columns, whole->counts.rows);
  return whole;
}

}  // namespace alidade
