// SPDX-License-Identifier: MIT
#include "alidade/target/charuco_board.h"

#include <algorithm>

#include "alidade/core/mapped.h"
#include "alidade/core/text.h"
#include "alidade/target/board_limits.h"

namespace alidade {
namespace {

// In the order of OpenCV's enumeration.
constexpr std::array<MarkerDictionary, 21> kDictionaries = {
    {{"DICT_4X4_50", 50, 4},        {"DICT_4X4_100", 100, 4},         {"DICT_4X4_250", 250, 4},
     {"DICT_4X4_1000", 1000, 4},    {"DICT_5X5_50", 50, 5},           {"DICT_5X5_100", 100, 5},
     {"DICT_5X5_250", 250, 5},      {"DICT_5X5_1000", 1000, 5},       {"DICT_6X6_50", 50, 6},
     {"DICT_6X6_100", 100, 6},      {"DICT_6X6_250", 250, 6},         {"DICT_6X6_1000", 1000, 6},
     {"DICT_7X7_50", 50, 7},        {"DICT_7X7_100", 100, 7},         {"DICT_7X7_250", 250, 7},
     {"DICT_7X7_1000", 1000, 7},    {"DICT_ARUCO_ORIGINAL", 1024, 5}, {"DICT_APRILTAG_16h5", 30, 4},
     {"DICT_APRILTAG_25h9", 35, 5}, {"DICT_APRILTAG_36h10", 2320, 6}, {"DICT_APRILTAG_36h11", 587, 6}}};

// The name in lower case, with the prefix that users often omit.
std::string plainName(std::string_view name) {
  std::string plain(name);
  for (char& c : plain) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return plain.starts_with("dict_") ? plain : "dict_" + plain;
}

BoardFault unknownDictionary(const std::string& name) {
  const auto nameOf = [](const MarkerDictionary& dictionary) { return std::string(dictionary.name); };
  const std::vector<std::string> names = mapped(kDictionaries, nameOf);
  const std::vector<std::string> plain_names = mapped(names, plainName);
  BoardFault fault{.found = "the dictionary '" + name + "'",
                   .expected = "one of OpenCV's, such as DICT_4X4_50",
                   .next_step = "expected one of " + join(names, ", ")};
  if (const auto nearest = nearestName(plainName(name), plain_names); nearest && !name.empty()) {
    const auto at = std::ranges::find(plain_names, *nearest) - plain_names.begin();
    fault.next_step = "did you mean '" + names[static_cast<std::size_t>(at)] + "'?";
  }
  return fault;
}

}  // namespace

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

std::optional<BoardFault> CharucoBoard::fault() const {
  if (auto fault = detail::countsFault(columns, rows, 3, 100, kWords.counted)) return fault;
  if (auto fault = detail::sideFault(square_m, kWords.counted)) return fault;
  if (!(marker_m >= 0.3 * square_m && marker_m <= 0.95 * square_m)) {
    return BoardFault{.found = "markers of " + exactText(1000 * marker_m) + " mm in squares of " +
                               exactText(1000 * square_m) + " mm",
                      .expected = "markers of 0.3 to 0.95 of the square"};
  }
  const auto known = findMarkerDictionary(dictionary);
  if (!known) return unknownDictionary(dictionary);
  if (known->num_markers < numMarkers(true)) {
    return BoardFault{
        .found = "a board of up to " + std::to_string(numMarkers(true)) + " markers",
        .expected = "at most " + std::to_string(known->num_markers) + ", as " + dictionary + " has"};
  }
  return std::nullopt;
}

}  // namespace alidade
