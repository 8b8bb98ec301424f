// SPDX-License-Identifier: MIT
// What boards of each kind can be.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "alidade/core/text.h"
#include "alidade/target/april_grid.h"
#include "alidade/target/charuco_board.h"
#include "alidade/target/checkerboard.h"
#include "alidade/target/circle_grid.h"

namespace alidade {
namespace {

// A square of a tenth of a millimetre is under a microscope, one of two metres on a hangar's floor.
constexpr double kMinSide = 1e-4;
constexpr double kMaxSide = 2.0;

std::optional<BoardFault> countsFault(int columns, int rows, int least, int most, const std::string& what) {
  if (std::min(columns, rows) >= least && std::max(columns, rows) <= most) return std::nullopt;
  return BoardFault{
      .found = std::to_string(columns) + "x" + std::to_string(rows) + " " + what,
      .expected = "between " + std::to_string(least) + " and " + std::to_string(most) + " in each direction"};
}

std::optional<BoardFault> sideFault(double side_m, const std::string& what) {
  if (side_m >= kMinSide && side_m <= kMaxSide) return std::nullopt;
  BoardFault fault{.found = what + " of " + exactText(side_m) + " m", .expected = "between 0.1 mm and 2 m"};
  if (side_m > kMaxSide && side_m <= 1000 * kMaxSide)
    fault.next_step = "a bare number is metres: did you mean " + exactText(side_m) + "mm?";
  return fault;
}

// Discs must leave room between them, and be large enough beside it to be seen where their grid is.
std::optional<BoardFault> circlesFault(int columns, int rows, int least_columns, double spacing_m,
                                       double diameter_m, double neighbour_m) {
  if (auto fault = countsFault(columns, rows, least_columns, 100, "circles")) return fault;
  if (auto fault = countsFault(rows, rows, 3, 100, "rows of circles")) return fault;
  if (auto fault = sideFault(spacing_m, "a spacing")) return fault;
  if (diameter_m >= 0.15 * neighbour_m && diameter_m <= 0.9 * neighbour_m) return std::nullopt;
  return BoardFault{.found = "circles of " + exactText(1000 * diameter_m) + " mm, whose neighbours are " +
                             exactText(std::round(1e5 * neighbour_m) / 100) + " mm away",
                    .expected = "diameters of 0.15 to 0.9 of that distance"};
}

// In the order of OpenCV's numbers.
constexpr std::array<MarkerDictionary, 21> kDictionaries = {
    {{"DICT_4X4_50", 50, 4},        {"DICT_4X4_100", 100, 4},         {"DICT_4X4_250", 250, 4},
     {"DICT_4X4_1000", 1000, 4},    {"DICT_5X5_50", 50, 5},           {"DICT_5X5_100", 100, 5},
     {"DICT_5X5_250", 250, 5},      {"DICT_5X5_1000", 1000, 5},       {"DICT_6X6_50", 50, 6},
     {"DICT_6X6_100", 100, 6},      {"DICT_6X6_250", 250, 6},         {"DICT_6X6_1000", 1000, 6},
     {"DICT_7X7_50", 50, 7},        {"DICT_7X7_100", 100, 7},         {"DICT_7X7_250", 250, 7},
     {"DICT_7X7_1000", 1000, 7},    {"DICT_ARUCO_ORIGINAL", 1024, 5}, {"DICT_APRILTAG_16h5", 30, 4},
     {"DICT_APRILTAG_25h9", 35, 5}, {"DICT_APRILTAG_36h10", 2320, 6}, {"DICT_APRILTAG_36h11", 587, 6}}};

}  // namespace

std::optional<MarkerDictionary> findMarkerDictionary(std::string_view name) {
  const auto* found = std::ranges::find(kDictionaries, name, &MarkerDictionary::name);
  if (found == kDictionaries.end()) return std::nullopt;
  MarkerDictionary dictionary = *found;
  dictionary.opencv_id = static_cast<int>(found - kDictionaries.begin());
  return dictionary;
}

std::optional<BoardFault> Checkerboard::fault() const {
  if (auto fault = countsFault(columns, rows, 3, 200, "inner corners")) return fault;
  return sideFault(square_m, "squares");
}

std::optional<BoardFault> CharucoBoard::fault() const {
  if (auto fault = countsFault(columns, rows, 3, 100, "squares")) return fault;
  if (auto fault = sideFault(square_m, "squares")) return fault;
  if (!(marker_m >= 0.3 * square_m && marker_m <= 0.95 * square_m)) {
    return BoardFault{.found = "markers of " + exactText(1000 * marker_m) + " mm in squares of " +
                               exactText(1000 * square_m) + " mm",
                      .expected = "markers of 0.3 to 0.95 of the square"};
  }
  const auto known = findMarkerDictionary(dictionary);
  if (!known) {
    std::vector<std::string> names;
    for (const MarkerDictionary& candidate : kDictionaries) names.emplace_back(candidate.name);
    return BoardFault{.found = "the dictionary '" + dictionary + "'",
                      .expected = "one of OpenCV's, such as DICT_4X4_50",
                      .next_step = didYouMean(dictionary, names, "expected one of " + join(names, ", "))};
  }
  if (known->num_markers < numMarkers(true)) {
    return BoardFault{
        .found = "a board of up to " + std::to_string(numMarkers(true)) + " markers",
        .expected = "at most " + std::to_string(known->num_markers) + ", as " + dictionary + " has"};
  }
  return std::nullopt;
}

std::optional<BoardFault> AprilGrid::fault() const {
  if (auto fault = countsFault(columns, rows, 1, 24, "tags")) return fault;
  if (auto fault = sideFault(tag_m, "tags")) return fault;
  if (!(gap >= 0.1 && gap <= 1)) {
    return BoardFault{.found = "gaps of " + exactText(gap) + " tags", .expected = "between 0.1 and 1"};
  }
  const int most = findMarkerDictionary(kDictionary)->num_markers;
  if (columns * rows < 2 || first_id < 0 || first_id > most - columns * rows) {
    return BoardFault{.found = std::to_string(columns * rows) + " tags from id " + std::to_string(first_id),
                      .expected = "2 or more of the " + std::to_string(most) + " tags of the family 36h11"};
  }
  return std::nullopt;
}

std::optional<BoardFault> CircleGrid::fault() const {
  return circlesFault(columns, rows, 3, spacing_m, diameter_m, spacing_m);
}

std::optional<BoardFault> AsymmetricCircleGrid::fault() const {
  return circlesFault(columns, rows, 2, spacing_m, diameter_m, std::numbers::sqrt2 * spacing_m);
}

}  // namespace alidade
