// SPDX-License-Identifier: MIT
#include "alidade/detect/board/circle_grid_detector.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <type_traits>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "alidade/core/error.h"
#include "alidade/detect/board/circle_placement.h"
#include "alidade/detect/board/circle_search.h"
#include "alidade/detect/board/disc_lattice.h"
#include "alidade/target/board.h"

namespace alidade {
namespace {

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

Detection refuse(DetectionReason reason, std::string detail) {
  Detection detection;
  detection.reason = reason;
  detection.detail = std::move(detail);
  return detection;
}

Detection refuseOther(const SeenGrids& seen, const CircleCounts& asked) {
  if (seen.of_lattices.empty()) {
    return seen.num_lattices > 0
               ? refuse(DetectionReason::kUnplaced, "circles of a grid, but not all of its outer lines")
               : refuse(DetectionReason::kNoBoard, "no grid of circles was found");
  }
  const CircleCounts& counts = seen.of_lattices.front().front().counts;
  const bool is_part = std::max(counts.columns, counts.rows) <= std::max(asked.columns, asked.rows) &&
                       std::min(counts.columns, counts.rows) <= std::min(asked.columns, asked.rows) &&
                       counts.is_asymmetric == asked.is_asymmetric;
  return refuse(is_part ? DetectionReason::kUnplaced : DetectionReason::kOtherBoard,
                fmt::format("{}, not {}{}", countsText(counts), countsText(asked),
                            is_part ? "; all of the outer lines must be seen" : ""));
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
    return refuse(DetectionReason::kSeveralBoards,
                  fmt::format("{} grids of {}", num_matches, countsText(asked)));
  }
  const CircleSearch search(image, board,
                            *chosenPlacement(*std::ranges::find_if(seen.of_lattices, isAsked), asked));
  Detection detection;
  for (std::size_t i = 0; i < search.found().size(); ++i) {
    const auto& disc = search.found()[i];
    if (disc) {
      detection.corners.push_back(
          {.id = static_cast<int>(i), .pixel = disc->pixel, .sigma_px = disc->sigma_px});
    }
  }
  const std::size_t num_found = detection.corners.size();
  if (2 * num_found < search.found().size()) {
    return refuse(
        DetectionReason::kBlurred,
        fmt::format("a grid of circles, of which only {} are clear enough to be located", num_found));
  }
  const auto proportions = search.proportions();
  if (const std::string other = proportions ? otherProportion(*proportions, board) : ""; !other.empty())
    return refuse(DetectionReason::kOtherBoard, other);
  detection.measures = search.measures();
  detection.reason = DetectionReason::kFound;
  if (num_found < search.found().size()) {
    detection.reason = DetectionReason::kPartial;
    detection.detail = fmt::format("{} of {} circles; the others are covered or not clear enough", num_found,
                                   search.found().size());
  }
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
