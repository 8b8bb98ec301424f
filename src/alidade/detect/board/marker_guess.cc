// SPDX-License-Identifier: MIT
#include "alidade/detect/board/marker_guess.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "alidade/core/mapped.h"
#include "alidade/core/median.h"
#include "alidade/core/text.h"
#include "alidade/detect/board/find_board.h"
#include "alidade/detect/board/marker_layout.h"
#include "alidade/detect/board/marker_share.h"
#include "alidade/target/board.h"

namespace alidade {
namespace {

using Eigen::Vector2d;

constexpr std::size_t kEnoughMarkers = 4;  // so many different ones are no coincidence
constexpr std::size_t kEnoughImages = 4;   // images with markers
constexpr std::size_t kMostImages = 12;

// The prints of AprilGrids with every border, then OpenCV's largest dictionary of each other kind; the
// smaller ones consist of its first markers.
const std::vector<MarkerPrint>& allPrints() {
  static const std::vector<MarkerPrint> kPrints = [] {
    std::vector<MarkerPrint> prints;
    // Markers with a border of one cell may belong to a ChArUco board, whose squares come near them.
    for (const int border : AprilGrid::kBorders)
      prints.push_back(
          {.dictionary = std::string(AprilGrid::kDictionary), .border = border, .is_apart = border > 1});
    for (const char* const name :
         {"DICT_4X4_1000", "DICT_5X5_1000", "DICT_6X6_1000", "DICT_7X7_1000", "DICT_ARUCO_ORIGINAL",
          "DICT_APRILTAG_36h10", "DICT_APRILTAG_25h9", "DICT_APRILTAG_16h5"})
      prints.push_back({.dictionary = name});
    return prints;
  }();
  return kPrints;
}

bool isOfAprilGrid(const MarkerPrint& print) {
  return print.dictionary == AprilGrid::kDictionary;
}

// The smallest dictionary of the same kind with at least this many markers.
std::string dictionaryWith(const std::string& largest, int num_markers) {
  for (const char* const size : {"_50", "_100", "_250"}) {
    const auto known = findMarkerDictionary(markerFamily(largest) + size);
    if (known && known->num_markers >= num_markers) return std::string(known->name);
  }
  return largest;
}

// Rounds to a share that a user may have chosen, if one is within the uncertainty of the measurement.
double plausibleShare(double measured) {
  constexpr double kNear = 0.015;  // of the share
  for (const double step : {0.05, 0.01}) {
    const double plausible = step * std::round(measured / step);
    if (std::abs(plausible - measured) <= kNear * std::min(measured, 10 * step)) return plausible;
  }
  return measured;
}

using Images = std::vector<const MarkedImage*>;

const Corner* findCorner(const Detection& detection, int id) {
  const auto at = std::ranges::lower_bound(detection.corners, id, {}, &Corner::id);
  return at != detection.corners.end() && at->id == id ? &*at : nullptr;
}

// True if corners of a row of the board were found.
bool showRow(const std::vector<Detection>& detections, int columns, int row) {
  constexpr std::ptrdiff_t kLeast = 2;
  return std::ranges::any_of(detections, [&](const Detection& detection) {
    return std::ranges::count_if(detection.corners,
                                 [&](const Corner& corner) { return corner.id / columns == row; }) >= kLeast;
  });
}

// The ratio of a gap to a tag, from the cross-ratio of four collinear corners, which is invariant under
// perspective.
std::optional<double> gapByCrossRatio(const std::vector<Detection>& detections, int num_columns,
                                      int num_rows) {
  std::vector<double> gaps;
  const auto look = [&](const Detection& detection, const Corner& first, int step, int place, int count) {
    if (place % 2 != 0 || place + 3 >= count) return;
    std::array<const Corner*, 4> c = {&first};
    for (int k = 1; k < 4; ++k) c[static_cast<std::size_t>(k)] = findCorner(detection, first.id + k * step);
    if (std::ranges::count(c, nullptr) > 0) return;
    const auto distance = [&](std::size_t a, std::size_t b) { return (c[a]->pixel - c[b]->pixel).norm(); };
    // For places 0, 1, 1 + gap and 2 + gap, the ratio is t / (t - 1), where t is the square of 1 + gap.
    const double ratio = distance(0, 2) * distance(1, 3) / (distance(1, 2) * distance(0, 3));
    if (ratio > 1) gaps.push_back(std::sqrt(ratio / (ratio - 1)) - 1);
  };
  for (const Detection& detection : detections) {
    for (const Corner& corner : detection.corners) {
      look(detection, corner, 1, corner.id % num_columns, num_columns);
      look(detection, corner, num_columns, corner.id / num_columns, num_rows);
    }
  }
  return gaps.empty() ? std::nullopt : std::optional(medianOf(std::move(gaps)));
}

// The four corners of the square whose lowest id is `first`.
std::optional<std::array<Vector2d, 4>> squareFrom(const Detection& detection, const Corner& first,
                                                  int columns) {
  const std::array<const Corner*, 4> c = {&first, findCorner(detection, first.id + 1),
                                          findCorner(detection, first.id + 1 + columns),
                                          findCorner(detection, first.id + columns)};
  if (first.id % columns + 1 == columns || std::ranges::count(c, nullptr) > 0) return std::nullopt;
  return std::array{c[0]->pixel, c[1]->pixel, c[2]->pixel, c[3]->pixel};
}

double diagonalsOf(const std::array<Vector2d, 4>& corners) {
  return (corners[2] - corners[0]).norm() + (corners[3] - corners[1]).norm();
}

// The ratio of a marker to its square, where all four corners of the square were found: from the marker's
// edges if they are clear, otherwise from the corners of outlines.
std::optional<double> markerShare(const std::vector<Detection>& detections, const Images& images,
                                  std::size_t print, int columns) {
  std::vector<double> coarse;
  std::vector<double> fine;
  for (std::size_t i = 0; i < detections.size(); ++i) {
    for (const Corner& first : detections[i].corners) {
      const auto square = squareFrom(detections[i], first, columns);
      if (!square) continue;
      const double diagonals = diagonalsOf(*square);
      constexpr double kNear = 0.1;
      for (const SeenMarker& marker : images[i]->markers[print]) {
        if ((middleOf(marker.corners) - middleOf(*square)).norm() > kNear * diagonals) continue;
        coarse.push_back((diagonalsOf(marker.corners) + 2 * std::numbers::sqrt2 * images[i]->lost_px) /
                         diagonals);
        if (const auto share =
                measuredMarkerShare(images[i]->image, *square, coarse.back(), allPrints()[print].numCells()))
          fine.push_back(*share);
      }
    }
  }
  constexpr std::size_t kEnough = 3;
  if (coarse.empty()) return std::nullopt;
  return medianOf(std::move(fine.size() >= kEnough ? fine : coarse));
}

template <class Kind>
std::vector<Detection> detectIn(const Images& images, const Kind& board) {
  return mapped(images, [&](const MarkedImage* shown) { return findBoard(shown->image, board); });
}

bool anyFound(const std::vector<Detection>& detections) {
  return std::ranges::any_of(detections, &Detection::hasCorners);
}

constexpr int kMostRows = 100;
constexpr int kMostTagRows = 24;

// The board with the counts that follow from the ids, and with as many further rows as the images show.
std::optional<CharucoBoard> charucoOf(const MarkerLayout& layout, std::size_t print, const Images& images) {
  CharucoBoard board{.columns = layout.columns,
                     .rows = std::max(3, layout.rows),
                     .square_m = 1,
                     .marker_m = std::clamp(1 / layout.spacing, 0.3, 0.95),
                     .dictionary = allPrints()[print].dictionary,
                     .first_id = layout.first_id};
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
  const auto share = markerShare(detections, images, print, board.columns - 1);
  board.marker_m = plausibleShare(share.value_or(board.marker_m));
  board.dictionary = dictionaryWith(board.dictionary, board.first_id + board.numMarkers(true));
  return board;
}

// The same for an AprilGrid, with further rows at the bottom, which have lower ids, and at the top.
std::optional<AprilGrid> aprilGridOf(const MarkerLayout& layout, const Images& images) {
  AprilGrid board{.columns = layout.columns,
                  .rows = layout.rows,
                  .tag_m = 1,
                  .gap = std::clamp(layout.spacing - 1, 0.1, 1.0),
                  .first_id = layout.first_id};
  std::vector<Detection> detections = detectIn(images, board);
  if (!anyFound(detections)) return std::nullopt;
  const auto measureGap = [&] {
    const auto gap = gapByCrossRatio(detections, 2 * board.columns, 2 * board.rows);
    if (gap) board.gap = std::clamp(*gap, 0.1, 1.0);
  };
  measureGap();
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
  detections = detectIn(images, board);
  measureGap();
  board.gap = plausibleShare(board.gap);
  return board;
}

// The last part of a SPEC.
std::string firstIdText(int first_id) {
  return first_id == 0 ? "" : fmt::format(":{}", first_id);
}

std::string textOf(const CharucoBoard& board) {
  return fmt::format(
      "the images show a ChArUco board of {0}x{1} squares: --board charuco:{0}x{1}:SQUARE:MARKER:{2}{3}, "
      "with the sides of a square and of a marker, which is about {4:.3g} of it",
      board.columns, board.rows, board.dictionary, firstIdText(board.first_id), board.marker_m);
}

std::string textOf(const std::vector<AprilGrid>& boards) {
  std::vector<std::string> flags;
  for (const AprilGrid& board : boards) {
    flags.push_back(fmt::format("--board aprilgrid:{}x{}:TAG:{:.3g}{}", board.columns, board.rows, board.gap,
                                firstIdText(board.first_id)));
  }
  return fmt::format("the images show {} of {}x{} tags: {}, with the side of a tag such as 88mm",
                     boards.size() == 1 ? "an AprilGrid" : fmt::format("{} AprilGrids, one", boards.size()),
                     boards[0].columns, boards[0].rows, join(flags, " or "));
}

// Text for uncertain counts.
std::string textOf(const MarkerLayout& layout, const MarkerPrint& print) {
  const int lowest = layout.ids.front();
  const int highest = layout.ids.back();
  const std::string dictionary = dictionaryWith(print.dictionary, highest + 1);
  if (layout.is_diagonal) {
    return fmt::format(
        "the images show markers of {0} in a checkerboard, with ids from {1} to {2}: --board "
        "charuco:COLUMNSxROWS:SQUARE:MARKER:{0}, counting squares",
        dictionary, lowest, highest);
  }
  if (isOfAprilGrid(print)) {
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
  constexpr std::size_t kMany = 16;  // a closer look would reveal no more
  const auto most = [](const std::vector<std::vector<SeenMarker>>& markers) {
    return std::ranges::max(markers, {}, [](const auto& of_print) { return of_print.size(); }).size();
  };
  GrayImage shown = image;
  for (const bool is_inverted : {false, true}) {
    if (is_inverted) shown = negativeOf(std::move(shown));
    MarkedImage best;
    std::size_t most_seen = kEnoughMarkers - 1;
    bool are_framed = false;
    for (const MarkerLook& look : markerLooks(image.size)) {
      if (look.scale > 1 && !are_framed) break;
      SeenMarkers seen = seeMarkers(shown, allPrints(), look);
      are_framed = seen.areFramed();
      if (most(seen.of_prints) <= most_seen) continue;
      most_seen = most(seen.of_prints);
      // Outlines run through the centres of the outermost dark pixels.
      best = {.image = {}, .markers = std::move(seen.of_prints), .lost_px = 1 / look.scale};
      if (most_seen >= kMany) break;
    }
    if (best.markers.empty()) continue;
    best.image = std::move(shown);
    keep(std::move(best));
    return;
  }
}

void MarkerGuess::keep(MarkedImage seen) {
  bool is_news = false;
  for (std::size_t p = 0; p < seen.markers.size(); ++p) {
    if (seen.markers[p].size() < kEnoughMarkers) continue;
    for (const SeenMarker& marker : seen.markers[p]) is_news |= ids_.insert({p, marker.id}).second;
  }
  num_without_news_ = is_news ? 0 : num_without_news_ + 1;
  seen_.push_back(std::move(seen));
}

bool MarkerGuess::isSure() const {
  return seen_.size() >= kMostImages || (seen_.size() >= kEnoughImages && num_without_news_ >= 2);
}

std::vector<const MarkedImage*> MarkerGuess::tellingImages(std::size_t print) const {
  Images order;
  for (const MarkedImage& seen : seen_) {
    if (!seen.markers[print].empty()) order.push_back(&seen);
  }
  if (order.size() <= kEnoughImages) return order;
  const auto count = [&](const MarkedImage* seen) { return seen->markers[print].size(); };
  const auto lowest = [&](const MarkedImage* seen) {
    return std::ranges::min(seen->markers[print], {}, &SeenMarker::id).id;
  };
  const auto highest = [&](const MarkedImage* seen) {
    return std::ranges::max(seen->markers[print], {}, &SeenMarker::id).id;
  };
  const MarkedImage* const first = *std::ranges::min_element(order, {}, lowest);
  const MarkedImage* const last = *std::ranges::max_element(order, {}, highest);
  std::ranges::stable_sort(order, std::greater(), count);
  order.resize(kEnoughImages);
  for (const MarkedImage* const seen : {first, last}) {
    if (std::ranges::count(order, seen) == 0) order.push_back(seen);
  }
  return order;
}

std::string MarkerGuess::text() const {
  std::vector<MarkerLayout> best;
  std::size_t best_print = 0;
  std::size_t most = 0;
  for (std::size_t p = 0; p < allPrints().size(); ++p) {
    const auto markers = mapped(seen_, [&](const MarkedImage& seen) { return seen.markers[p]; });
    auto layouts = markerLayouts(markers, isOfAprilGrid(allPrints()[p]) && AprilGrid::kIsUpsideDown);
    std::size_t count = 0;
    for (const MarkerLayout& layout : layouts) count += layout.ids.size();
    if (count <= most) continue;
    most = count;
    best = std::move(layouts);
    best_print = p;
  }
  if (best.empty()) return {};
  const MarkerPrint& print = allPrints()[best_print];
  const Images images = tellingImages(best_print);
  const MarkerLayout& largest =
      *std::ranges::max_element(best, {}, [](const auto& l) { return l.ids.size(); });
  if (largest.columns > 0 && largest.is_diagonal && print.border == 1) {
    if (const auto board = charucoOf(largest, best_print, images)) return textOf(*board);
  }
  std::vector<AprilGrid> grids;
  for (const MarkerLayout& layout : best) {
    if (layout.columns == 0 || layout.is_diagonal || !isOfAprilGrid(print)) continue;
    if (const auto board = aprilGridOf(layout, images)) grids.push_back(*board);
  }
  return grids.empty() ? textOf(largest, print) : textOf(grids);
}

}  // namespace alidade
