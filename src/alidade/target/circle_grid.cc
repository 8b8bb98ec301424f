// SPDX-License-Identifier: MIT
#include "alidade/target/circle_grid.h"

#include <cmath>
#include <string>

#include "alidade/core/text.h"
#include "alidade/target/board_limits.h"

namespace alidade {
namespace {

// Discs must not touch, and must be large enough relative to their spacing to be seen.
std::optional<BoardFault> circlesFault(int columns, int rows, int least_columns, double spacing_m,
                                       double diameter_m, double neighbour_m) {
  if (auto fault = detail::countsFault(columns, rows, least_columns, 100, "circles")) return fault;
  if (auto fault = detail::countsFault(rows, rows, 3, 100, "rows of circles")) return fault;
  if (auto fault = detail::sideFault(spacing_m, "a spacing")) return fault;
  if (diameter_m >= 0.15 * neighbour_m && diameter_m <= 0.9 * neighbour_m) return std::nullopt;
  return BoardFault{.found = "circles of " + exactText(1000 * diameter_m) + " mm, whose neighbours are " +
                             exactText(std::round(1e5 * neighbour_m) / 100) + " mm away",
                    .expected = "diameters of 0.15 to 0.9 of that distance"};
}

}  // namespace

std::optional<BoardFault> CircleGrid::fault() const {
  return circlesFault(columns, rows, 3, spacing_m, diameter_m, spacing_m);
}

std::optional<BoardFault> AsymmetricCircleGrid::fault() const {
  return circlesFault(columns, rows, 2, spacing_m, diameter_m, std::numbers::sqrt2 * spacing_m);
}

}  // namespace alidade
