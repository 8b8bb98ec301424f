// SPDX-License-Identifier: MIT
#include "alidade/detect/board/marker_guess.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "alidade/core/median.h"
#include "alidade/core/text.h"
#include "alidade/detect/board/april_grid_detector.h"
#include "alidade/detect/board/charuco_detector.h"
#include "alidade/detect/board/marker_layout.h"
#include "alidade/target/board.h"

namespace alidade {
namespace {

using Eigen::Vector2d;

constexpr std::size_t kEnoughMarkers = 4;  // as many different ones are no accident
constexpr std::size_t kMaxImages = 4;      // with markers

// OpenCV's smaller dictionaries are the first markers of the largest one of their kind.
struct MarkerFamily {
  std::string_view largest;
  int border = 1;
  std::array<std::string_view, 3> smaller = {};
};

constexpr std::array<MarkerFamily, 11> kFamilies = {
    {{"DICT_APRILTAG_36h11", 2},
     {"DICT_APRILTAG_36h11", 1},
     {"DICT_APRILTAG_36h11", 3},
     {"DICT_4X4_1000", 1, {"DICT_4X4_50", "DICT_4X4_100", "DICT_4X4_250"}},
     {"DICT_5X5_1000", 1, {"DICT_5X5_50", "DICT_5X5_100", "DICT_5X5_250"}},
     {"DICT_6X6_1000", 1, {"DICT_6X6_50", "DICT_6X6_100", "DICT_6X6_250"}},
     {"DICT_7X7_1000", 1, {"DICT_7X7_50", "DICT_7X7_100", "DICT_7X7_250"}},
     {"DICT_ARUCO_ORIGINAL", 1},
     {"DICT_APRILTAG_36h10", 1},
     {"DICT_APRILTAG_25h9", 1},
     {"DICT_APRILTAG_16h5", 1}}};

std::vector<MarkerPrint> allPrints() {
  std::vector<MarkerPrint> prints;
  for (const MarkerFamily& family : kFamilies)
    prints.push_back({.dictionary = std::string(family.largest), .border = family.border});
  return prints;
}

// The smallest dictionary of the family that has so many markers.
std::string dictionaryWith(const MarkerFamily& family, int num_markers) {
  for (const std::string_view name : family.smaller) {
    const auto known = findMarkerDictionary(name);
    if (known && known->num_markers >= num_markers) return std::string(name);
  }
  return std::string(family.largest);
}

// To what somebody may have chosen: a multiple of 0.05 where one is near, or else of 0.01.
double plausibleShare(double measured) {
  constexpr double kCoarse = 0.05;
  constexpr double kFine = 0.01;
  constexpr double kNear = 0.012;
  const double coarse = kCoarse * std::round(measured / kCoarse);
  return std::abs(coarse - measured) <= kNear ? coarse : kFine * std::round(measured / kFine);
}

// An image and its markers of one print.
struct ShownMarkers {
  const GrayImage* image = nullptr;
  const std::vector<SeenMarker>* markers = nullptr;
  double lost_px = 0;
};

const Corner* findCorner(const Detection& detection, int id) {
  const auto at = std::ranges::lower_bound(detection.corners, id, {}, &Corner::id);
  return at != detection.corners.end() && at->id == id ? &*at : nullptr;
}

// Whether a row of the board has corners.
bool showRow(const std::vector<Detection>& detections, int columns, int row) {
  constexpr std::ptrdiff_t kLeast = 2;
  return std::ranges::any_of(detections, [&](const Detection& detection) {
    return std::ranges::count_if(detection.corners,
                                 [&](const Corner& corner) { return corner.id / columns == row; }) >= kLeast;
  });
}

// The ratio of a gap to a tag by the cross-ratio of four corners in a row, which no perspective changes.
std::optional<double> gapByCrossRatio(const std::vector<Detection>& detections, int num_columns) {
  std::vector<double> gaps;
  for (const Detection& detection : detections) {
    for (const Corner& first : detection.corners) {
      if (first.id % num_columns % 2 != 0 || first.id % num_columns + 3 >= num_columns) continue;
      std::array<const Corner*, 4> c = {&first};
      for (int k = 1; k < 4; ++k) c[static_cast<std::size_t>(k)] = findCorner(detection, first.id + k);
      if (std::ranges::count(c, nullptr) > 0) continue;
      const auto distance = [&](std::size_t a, std::size_t b) { return (c[a]->pixel - c[b]->pixel).norm(); };
      // Of places 0, 1, 1 + gap and 2 + gap it is t / (t - 1), where t is the square of 1 + gap.
      const double ratio = distance(0, 2) * distance(1, 3) / (distance(1, 2) * distance(0, 3));
      if (ratio > 1) gaps.push_back(std::sqrt(ratio / (ratio - 1)) - 1);
    }
  }
  return gaps.empty() ? std::nullopt : std::optional(medianOf(std::move(gaps)));
}

// The ratio of a marker to its square, where all four corners of the square are found.
std::optional<double> markerShare(const std::vector<Detection>& detections,
                                  const std::vector<ShownMarkers>& images, int columns) {
  std::vector<double> shares;
  for (std::size_t i = 0; i < detections.size(); ++i) {
    for (const Corner& first : detections[i].corners) {
      const std::array<const Corner*, 4> c = {&first, findCorner(detections[i], first.id + 1),
                                              findCorner(detections[i], first.id + 1 + columns),
                                              findCorner(detections[i], first.id + columns)};
      if (first.id % columns + 1 == columns || std::ranges::count(c, nullptr) > 0) continue;
      const Vector2d middle = 0.25 * (c[0]->pixel + c[1]->pixel + c[2]->pixel + c[3]->pixel);
      const double diagonals = (c[2]->pixel - c[0]->pixel).norm() + (c[3]->pixel - c[1]->pixel).norm();
      for (const SeenMarker& marker : *images[i].markers) {
        constexpr double kNear = 0.1;
        if ((middleOf(marker.corners) - middle).norm() > kNear * diagonals) continue;
        const double seen_diagonals =
            (marker.corners[2] - marker.corners[0]).norm() + (marker.corners[3] - marker.corners[1]).norm();
        shares.push_back((seen_diagonals + 2 * std::numbers::sqrt2 * images[i].lost_px) / diagonals);
      }
    }
  }
  return shares.empty() ? std::nullopt : std::optional(medianOf(std::move(shares)));
}

template <class Kind>
std::vector<Detection> detectIn(const std::vector<ShownMarkers>& images, const Kind& board) {
  std::vector<Detection> detections;
  for (const ShownMarkers& shown : images) detections.push_back(findBoard(*shown.image, board));
  return detections;
}

bool anyFound(const std::vector<Detection>& detections) {
  return std::ranges::any_of(detections, &Detection::hasCorners);
}

constexpr int kMostRows = 100;
constexpr int kMostTagRows = 24;

// The counts that the ids tell, with as many further rows as the images show.
std::optional<CharucoBoard> charucoOf(const MarkerLayout& layout, const MarkerFamily& family,
                                      const std::vector<ShownMarkers>& images) {
  CharucoBoard board{.columns = layout.columns,
                     .rows = std::max(3, layout.rows),
                     .square_m = 1,
                     .marker_m = std::clamp(1 / layout.spacing, 0.3, 0.95),
                     .dictionary = std::string(family.largest)};
  std::vector<Detection> detections = detectIn(images, board);
  if (!anyFound(detections)) return std::nullopt;
  while (board.rows < kMostRows) {
    CharucoBoard larger = board;
    ++larger.rows;
    std::vector<Detection> beyond = detectIn(images, larger);
    if (!showRow(beyond, board.columns - 1, board.rows - 1)) break;
    board = larger;
    detections = std::move(beyond);
  }
  const auto share = markerShare(detections, images, board.columns - 1);
  board.marker_m = plausibleShare(share.value_or(board.marker_m));
  board.dictionary = dictionaryWith(family, board.numMarkers(true));
  return board;
}

// The same with further rows at the bottom, which have lower ids, and at the top.
std::optional<AprilGrid> aprilGridOf(const MarkerLayout& layout, const std::vector<ShownMarkers>& images) {
  AprilGrid board{.columns = layout.columns,
                  .rows = layout.rows,
                  .tag_m = 1,
                  .gap = std::clamp(layout.spacing - 1, 0.1, 1.0),
                  .first_id = layout.first_id};
  std::vector<Detection> detections = detectIn(images, board);
  if (!anyFound(detections)) return std::nullopt;
  for (const bool is_at_bottom : {true, false}) {
    while (board.rows < kMostTagRows && (!is_at_bottom || board.first_id >= board.columns)) {
      AprilGrid larger = board;
      ++larger.rows;
      if (is_at_bottom) larger.first_id -= board.columns;
      std::vector<Detection> beyond = detectIn(images, larger);
      if (!showRow(beyond, 2 * board.columns, is_at_bottom ? 2 * board.rows + 1 : 0)) break;
      board = larger;
      detections = std::move(beyond);
    }
  }
  const auto gap = gapByCrossRatio(detections, 2 * board.columns);
  board.gap = plausibleShare(gap.value_or(board.gap));
  return board;
}

std::string textOf(const CharucoBoard& board) {
  return fmt::format(
      "the images show a ChArUco board of {0}x{1} squares: --board charuco:{0}x{1}:SQUARE:MARKER:{2}, with "
      "the "
      "sides of a square and of a marker, which is about {3:.2g} of it",
      board.columns, board.rows, board.dictionary, board.marker_m);
}

std::string textOf(const std::vector<AprilGrid>& boards) {
  std::vector<std::string> flags;
  for (const AprilGrid& board : boards) {
    flags.push_back(fmt::format("--board aprilgrid:{}x{}:TAG:{:.2g}", board.columns, board.rows, board.gap) +
                    (board.first_id == 0 ? "" : fmt::format(":{}", board.first_id)));
  }
  return fmt::format("the images show {} of {}x{} tags: {}, with the side of a tag such as 88mm",
                     boards.size() == 1 ? "an AprilGrid" : fmt::format("{} AprilGrids, one", boards.size()),
                     boards[0].columns, boards[0].rows, join(flags, " or "));
}

// Where the counts are not certain.
std::string textOf(const MarkerLayout& layout, const MarkerFamily& family) {
  const int lowest = layout.ids.front();
  const int highest = layout.ids.back();
  const std::string dictionary = dictionaryWith(family, highest + 1);
  const bool is_april = family.largest == AprilGrid::kDictionary;
  if (layout.lattice == MarkerLattice::kDiagonal) {
    return fmt::format(
        "the images show markers of {0} in a checkerboard, with ids from {1} to {2}: --board "
        "charuco:COLUMNSxROWS:SQUARE:MARKER:{0}, counting squares",
        dictionary, lowest, highest);
  }
  if (is_april) {
    return fmt::format(
        "the images show AprilTags with ids from {} to {}: --board aprilgrid:COLUMNSxROWS:TAG:GAP, counting "
        "tags",
        lowest, highest);
  }
  return fmt::format(
      "the images show markers of {} in columns and rows, with ids from {} to {}, which is not a board that "
      "Alidade finds",
      dictionary, lowest, highest);
}

}  // namespace

void MarkerGuess::look(const GrayImage& image) {
  static const std::vector<MarkerPrint> prints = allPrints();
  const auto isEnough = [](const std::vector<std::vector<SeenMarker>>& markers) {
    return std::ranges::any_of(markers,
                               [](const auto& of_print) { return of_print.size() >= kEnoughMarkers; });
  };
  GrayImage shown = image;
  for (const bool is_inverted : {false, true}) {
    if (is_inverted) {
      for (std::uint8_t& pixel : shown.pixels) pixel = static_cast<std::uint8_t>(255 - pixel);
    }
    for (const MarkerLook& look : markerLooks(image.size)) {
      auto markers = seeMarkers(shown, prints, look);
      if (!isEnough(markers)) continue;
      // Outlines run through the middles of the outermost dark pixels.
      seen_.push_back({.image = std::move(shown), .markers = std::move(markers), .lost_px = 1 / look.scale});
      return;
    }
  }
}

bool MarkerGuess::isSure() const {
  return seen_.size() >= kMaxImages;
}

std::string MarkerGuess::text() const {
  std::vector<MarkerLayout> best;
  std::size_t best_family = 0;
  std::size_t most = 0;
  for (std::size_t f = 0; f < kFamilies.size(); ++f) {
    std::vector<std::vector<SeenMarker>> markers;
    for (const Seen& seen : seen_) markers.push_back(seen.markers[f]);
    const bool is_april = kFamilies[f].largest == AprilGrid::kDictionary;
    auto layouts = markerLayouts(markers, is_april && AprilGrid::kIsUpsideDown);
    std::size_t count = 0;
    for (const MarkerLayout& layout : layouts) count += layout.ids.size();
    if (count <= most) continue;
    most = count;
    best = std::move(layouts);
    best_family = f;
  }
  if (best.empty()) return {};
  const MarkerFamily& family = kFamilies[best_family];
  std::vector<ShownMarkers> images;
  for (const Seen& seen : seen_)
    images.push_back({.image = &seen.image, .markers = &seen.markers[best_family], .lost_px = seen.lost_px});
  const MarkerLayout& largest =
      *std::ranges::max_element(best, {}, [](const auto& l) { return l.ids.size(); });
  if (largest.columns > 0 && largest.lattice == MarkerLattice::kDiagonal && family.border == 1) {
    if (const auto board = charucoOf(largest, family, images)) return textOf(*board);
  }
  std::vector<AprilGrid> grids;
  for (const MarkerLayout& layout : best) {
    if (layout.columns == 0 || layout.lattice != MarkerLattice::kUpright ||
        family.largest != AprilGrid::kDictionary)
      continue;
    if (const auto board = aprilGridOf(layout, images)) grids.push_back(*board);
  }
  return grids.empty() ? textOf(largest, family) : textOf(grids);
}

}  // namespace alidade
