// SPDX-License-Identifier: MIT
#include "alidade/detect/board_guess.h"

#include <algorithm>
#include <array>
#include <map>
#include <set>

#include <fmt/format.h>

#include "alidade/core/error.h"
#include "alidade/detect/board/checkerboard_detector.h"
#include "alidade/detect/board/marker_search.h"
#include "alidade/imagery/image_file.h"

namespace alidade {
namespace {

constexpr std::size_t kMaxImages = 6;
constexpr std::size_t kMinMarkers = 4;  // as many different ones are no accident

// The sets of which OpenCV's smaller ones are the first markers, and their sizes.
struct MarkerFamily {
  std::string_view stem;
  std::array<int, 4> sizes;
};
constexpr std::array<MarkerFamily, 4> kFamilies = {{{"DICT_4X4_", {50, 100, 250, 1000}},
                                                    {"DICT_5X5_", {50, 100, 250, 1000}},
                                                    {"DICT_6X6_", {50, 100, 250, 1000}},
                                                    {"DICT_7X7_", {50, 100, 250, 1000}}}};

std::string guessFromMarkers(const GrayImage& image) {
  for (const int border : {2, 1}) {
    const std::set<int> ids = markerIds(image, std::string(AprilGrid::kDictionary), border);
    if (ids.size() < kMinMarkers) continue;
    return fmt::format(
        "the images show AprilTags with ids from {} to {}: --board aprilgrid:COLUMNSxROWS:TAG:GAP, counting "
        "tags",
        *ids.begin(), *ids.rbegin());
  }
  for (const MarkerFamily& family : kFamilies) {
    const std::string all = std::string(family.stem) + std::to_string(family.sizes.back());
    const std::set<int> ids = markerIds(image, all, 1);
    if (ids.size() < kMinMarkers) continue;
    const int size = *std::ranges::find_if(family.sizes, [&](int n) { return *ids.rbegin() < n; });
    return fmt::format(
        "the images show markers of {}{}, with ids from {} to {}: --board "
        "charuco:COLUMNSxROWS:SQUARE:MARKER:{}{}, counting squares",
        family.stem, size, *ids.begin(), *ids.rbegin(), family.stem, size);
  }
  return {};
}

}  // namespace

std::string guessedBoard(std::span<const std::string> paths) {
  std::map<std::pair<int, int>, int> counts;
  const std::size_t count = std::min(kMaxImages, paths.size());
  for (std::size_t i = 0; i < count; ++i) {
    GrayImage image;
    try {
      image = readGrayImage(paths[i * paths.size() / count]).image;
    } catch (const Error&) {
      continue;  // the run itself will say so
    }
    const std::string by_markers = i < 2 ? guessFromMarkers(image) : "";
    if (!by_markers.empty()) return by_markers;
    // Any counts do: what is seen is told beside them.
    const auto seen = findBoard(image, Checkerboard{.columns = 3, .rows = 3, .square_m = 1}).seen;
    if (seen && seen->is_closed) ++counts[{seen->columns, seen->rows}];
  }
  if (counts.empty()) return {};
  const auto [columns, rows] =
      std::ranges::max_element(counts, {}, [](const auto& entry) { return entry.second; })->first;
  return fmt::format(
      "the images show a checkerboard of {0}x{1} inner corners: --board checkerboard:{0}x{1}:SQUARE, with "
      "the "
      "side of a square such as 25mm",
      columns, rows);
}

}  // namespace alidade
