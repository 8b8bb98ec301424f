// SPDX-License-Identifier: MIT
#include "alidade/target/board_kinds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "alidade/core/aliases.h"
#include "alidade/core/mapped.h"
#include "alidade/core/text.h"

namespace alidade {
namespace {

// `what` names the counted parts.
std::optional<ErrorDetail> countsFault(int columns, int rows, int least, int most, std::string_view what) {
  if (std::min(columns, rows) >= least && std::max(columns, rows) <= most) return std::nullopt;
  return ErrorDetail{
      .found = std::to_string(columns) + "x" + std::to_string(rows) + " " + std::string(what),
      .expected = "between " + std::to_string(least) + " and " + std::to_string(most) + " in each direction"};
}

// `what` names the sides, in the plural.
std::optional<ErrorDetail> sideFault(double side_m, std::string_view what) {
  // A board with squares of 0.1 mm is for a microscope, one with squares of 2 m covers the floor of a hangar.
  constexpr double kMinSide = 1e-4;
  constexpr double kMaxSide = 2.0;
  if (side_m >= kMinSide && side_m <= kMaxSide) return std::nullopt;
  ErrorDetail fault{.found = std::string(what) + " of " + exactText(side_m) + " m",
                    .expected = "between 0.1 mm and 2 m"};
  if (side_m > kMaxSide && side_m <= 1000 * kMaxSide)
    fault.next_step = "a bare number is metres: did you mean " + exactText(side_m) + "mm?";
  return fault;
}

// Discs must not touch, and must be large enough relative to their spacing to be seen.
std::optional<ErrorDetail> circlesFault(int columns, int rows, int least_columns, double spacing_m,
                                        double diameter_m, double neighbour_m) {
  if (auto fault = countsFault(columns, rows, least_columns, 100, "circles")) return fault;
  if (auto fault = countsFault(rows, rows, 3, 100, "rows of circles")) return fault;
  if (auto fault = sideFault(spacing_m, "a spacing")) return fault;
  if (diameter_m >= 0.15 * neighbour_m && diameter_m <= 0.9 * neighbour_m) return std::nullopt;
  return ErrorDetail{.found = "circles of " + exactText(1000 * diameter_m) + " mm, whose neighbours are " +
                              exactText(std::round(1e5 * neighbour_m) / 100) + " mm away",
                     .expected = "diameters of 0.15 to 0.9 of that distance"};
}

// In the order of OpenCV's enumeration.
constexpr std::array<MarkerDictionary, 21> kDictionaries = {
    {{"DICT_4X4_50", 50, 4},        {"DICT_4X4_100", 100, 4},         {"DICT_4X4_250", 250, 4},
     {"DICT_4X4_1000", 1000, 4},    {"DICT_5X5_50", 50, 5},           {"DICT_5X5_100", 100, 5},
     {"DICT_5X5_250", 250, 5},      {"DICT_5X5_1000", 1000, 5},       {"DICT_6X6_50", 50, 6},
     {"DICT_6X6_100", 100, 6},      {"DICT_6X6_250", 250, 6},         {"DICT_6X6_1000", 1000, 6},
     {"DICT_7X7_50", 50, 7},        {"DICT_7X7_100", 100, 7},         {"DICT_7X7_250", 250, 7},
     {"DICT_7X7_1000", 1000, 7},    {"DICT_ARUCO_ORIGINAL", 1024, 5}, {"DICT_APRILTAG_16h5", 30, 4},
     {"DICT_APRILTAG_25h9", 35, 5}, {"DICT_APRILTAG_36h10", 2320, 6}, {"DICT_APRILTAG_36h11", 587, 6}}};

ErrorDetail unknownDictionary(const std::string& name) {
  // Users often omit the prefix.
  const auto names = mapped(kDictionaries, [](const MarkerDictionary& known) {
    return AliasedName{std::string(known.name), known.name.substr(std::string_view("DICT_").size())};
  });
  return {.found = "the dictionary '" + name + "'",
          .expected = "one of OpenCV's, such as DICT_4X4_50",
          .next_step =
              didYouMeanOne(name, names, "expected one of " + join(mapped(names, &AliasedName::name), ", "))};
}

std::optional<ErrorDetail> idsFault(int first_id, int count, std::string_view marker,
                                    const MarkerDictionary& of) {
  const int last_start = of.num_markers - count;
  if (first_id >= 0 && first_id <= last_start) return std::nullopt;
  return ErrorDetail{
      .found = std::to_string(count) + " " + std::string(marker) + "s from id " + std::to_string(first_id) +
               " to " + std::to_string(static_cast<long long>(first_id) + count - 1),
      .expected =
          "ids from 0 to " + std::to_string(of.num_markers - 1) + ", which " + std::string(of.name) + " has",
      .next_step = first_id < 0 ? "" : "the first id may be " + std::to_string(last_start) + " at most"};
}

}  // namespace

std::optional<ErrorDetail> Checkerboard::fault() const {
  if (auto fault = countsFault(columns, rows, 3, 200, kWords.counted)) return fault;
  return sideFault(square_m, "squares");
}

std::optional<MarkerDictionary> findMarkerDictionary(std::string_view name) {
  const auto* found = std::ranges::find(kDictionaries, name, &MarkerDictionary::name);
  if (found == kDictionaries.end()) return std::nullopt;
  MarkerDictionary dictionary = *found;
  dictionary.opencv_id = static_cast<int>(found - kDictionaries.begin());
  return dictionary;
}

std::string markerFamily(const std::string& dictionary) {
  const bool is_sized = dictionary.find('X') != std::string::npos;
  return is_sized ? dictionary.substr(0, dictionary.rfind('_')) : dictionary;
}

std::optional<ErrorDetail> CharucoBoard::fault() const {
  if (auto fault = countsFault(columns, rows, 3, 100, kWords.counted)) return fault;
  if (auto fault = sideFault(square_m, kWords.counted)) return fault;
  if (!(marker_m >= 0.3 * square_m && marker_m <= 0.95 * square_m)) {
    return ErrorDetail{.found = "markers of " + exactText(1000 * marker_m) + " mm in squares of " +
                                exactText(1000 * square_m) + " mm",
                       .expected = "markers of 0.3 to 0.95 of the square"};
  }
  const auto known = findMarkerDictionary(dictionary);
  if (!known) return unknownDictionary(dictionary);
  if (known->num_markers < numMarkers(true)) {
    return ErrorDetail{
        .found = "a board of up to " + std::to_string(numMarkers(true)) + " markers",
        .expected = "at most " + std::to_string(known->num_markers) + ", as " + dictionary + " has"};
  }
  return idsFault(first_id, numMarkers(true), kWords.marker, *known);
}

std::optional<ErrorDetail> AprilGrid::fault() const {
  if (auto fault = countsFault(columns, rows, 1, 24, kWords.counted)) return fault;
  const int count = columns * rows;
  if (count < 2) return ErrorDetail{.found = "1x1 tags", .expected = "2 tags or more"};
  if (auto fault = sideFault(tag_m, kWords.counted)) return fault;
  if (!(gap >= kLeastTagGap && gap <= kLargestTagGap)) {
    return ErrorDetail{.found = "gaps of " + exactText(gap) + " tags", .expected = "between 0.1 and 1"};
  }
  return idsFault(first_id, count, kWords.marker, *findMarkerDictionary(kDictionary));
}

std::optional<ErrorDetail> CircleGrid::fault() const {
  return circlesFault(columns, rows, 3, spacing_m, diameter_m, spacing_m);
}

std::optional<ErrorDetail> AsymmetricCircleGrid::fault() const {
  return circlesFault(columns, rows, 2, spacing_m, diameter_m, std::numbers::sqrt2 * spacing_m);
}

}  // namespace alidade
