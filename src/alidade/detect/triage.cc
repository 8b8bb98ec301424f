// SPDX-License-Identifier: MIT
#include "alidade/detect/triage.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "alidade/core/size_groups.h"
#include "alidade/core/text.h"

namespace alidade {
namespace {

void withdraw(Detection& detection, DetectionReason reason, std::string detail) {
  detection.reason = reason;
  detection.detail = std::move(detail);
  detection.corners.clear();
}

// The counts of a grid as seen, longer side first, are those of the board.
bool hasCountsOf(const SeenGrid& seen, const Checkerboard& board) {
  return seen.columns == std::max(board.columns, board.rows) &&
         seen.rows == std::min(board.columns, board.rows);
}

void refuseOtherSizes(std::span<ImageOutcome> outcomes, std::vector<std::string>& notes) {
  const bool any_corners =
      std::any_of(outcomes.begin(), outcomes.end(), [](const auto& o) { return o.detection.hasCorners(); });
  // Images without the board have no say in its size, unless there are no others.
  std::vector<ImageSize> sizes;
  for (const ImageOutcome& outcome : outcomes) {
    const bool is_readable = outcome.detection.reason != DetectionReason::kUnreadable;
    if (any_corners ? outcome.detection.hasCorners() : is_readable) sizes.push_back(outcome.size);
  }
  const SizeGroups groups = groupBySize(sizes);
  for (ImageOutcome& outcome : outcomes) {
    if (outcome.detection.reason == DetectionReason::kUnreadable || outcome.size == groups.size) continue;
    withdraw(outcome.detection, DetectionReason::kOtherSize,
             "is " + sizeText(outcome.size) + ", while most images are " + sizeText(groups.size));
  }
  if (!groups.others.empty()) {
    notes.push_back("images of " + std::string(groups.others.size() == 1 ? "two" : "several") +
                    " sizes were given; the " + std::to_string(groups.in_group.size()) + " of " +
                    sizeText(groups.size) + " are used");
  }
}

bool showSame(const std::vector<Corner>& a, const std::vector<Corner>& b) {
  if (a.size() != b.size() || a.empty()) return false;
  constexpr double kSamePx = 0.25;
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i].id != b[i].id) return false;
    sum += (a[i].pixel - b[i].pixel).squaredNorm();
  }
  return sum <= kSamePx * kSamePx * static_cast<double>(a.size());
}

// Only images whose first corners are in the same or neighbouring cells of a grid are compared.
void refuseDuplicates(std::span<ImageOutcome> outcomes) {
  constexpr double kCellPx = 4;
  std::map<std::pair<long, long>, std::vector<std::size_t>> cells;
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    Detection& detection = outcomes[i].detection;
    if (detection.corners.empty()) continue;
    const Eigen::Vector2d& first = detection.corners.front().pixel;
    const long x = std::lround(first.x() / kCellPx);
    const long y = std::lround(first.y() / kCellPx);
    std::size_t original = i;
    for (long dy = -1; dy <= 1; ++dy) {
      for (long dx = -1; dx <= 1; ++dx) {
        const auto cell = cells.find({x + dx, y + dy});
        if (cell == cells.end()) continue;
        for (const std::size_t k : cell->second) {
          if (showSame(outcomes[k].detection.corners, detection.corners)) original = std::min(original, k);
        }
      }
    }
    if (original == i) {
      cells[{x, y}].push_back(i);
    } else {
      withdraw(detection, DetectionReason::kDuplicate, "shows the same as " + outcomes[original].image);
    }
  }
}

void refuseUnclosed(std::span<ImageOutcome> outcomes, const std::string& detail) {
  for (ImageOutcome& outcome : outcomes) {
    Detection& detection = outcome.detection;
    const bool is_sure = detection.seen && detection.seen->is_closed;
    if (detection.hasCorners() && !is_sure) withdraw(detection, DetectionReason::kOtherBoard, detail);
  }
}

void refusePartsOfAnother(std::span<ImageOutcome> outcomes, const Checkerboard& board) {
  int num_with_corners = 0;
  int num_all_lines = 0;
  std::map<std::pair<int, int>, int> counts;
  for (const ImageOutcome& outcome : outcomes) {
    const Detection& detection = outcome.detection;
    if (!detection.hasCorners() || !detection.seen) continue;
    ++num_with_corners;
    num_all_lines += hasCountsOf(*detection.seen, board) ? 1 : 0;
    ++counts[{detection.seen->columns, detection.seen->rows}];
  }
  const auto hint = diagnoseBoard(outcomes, board);
  if (hint && hint->is_closed && hint->num_images > num_all_lines) {
    refuseUnclosed(outcomes, "may be a part of the board of " + std::to_string(hint->columns) + "x" +
                                 std::to_string(hint->rows) + " inner corners that other images show whole");
    return;
  }
  constexpr int kEnoughImages = 3;
  if (num_all_lines > 0 || num_with_corners < kEnoughImages) return;
  const auto commonest = std::max_element(counts.begin(), counts.end(),
                                          [](const auto& a, const auto& b) { return a.second < b.second; });
  if (2 * commonest->second <= num_with_corners) return;
  refuseUnclosed(outcomes, "no image shows all lines of a board of " + std::to_string(board.columns) + "x" +
                               std::to_string(board.rows) + " inner corners, most show " +
                               std::to_string(commonest->first.first) + "x" +
                               std::to_string(commonest->first.second));
}

// Images whose edges are much wider than those of most; their corners are used, with their large sigmas.
void noteBlurred(std::span<const ImageOutcome> outcomes, std::vector<std::string>& notes) {
  constexpr double kFactor = 2.5;
  constexpr double kSharpPx = 1.5;  // nobody minds less
  std::vector<double> blurs;
  for (const ImageOutcome& outcome : outcomes) {
    if (outcome.detection.hasCorners()) blurs.push_back(outcome.detection.measures.blur_px);
  }
  if (blurs.empty()) return;
  const auto middle = blurs.begin() + static_cast<std::ptrdiff_t>(blurs.size() / 2);
  std::nth_element(blurs.begin(), middle, blurs.end());
  const double limit = std::max(kSharpPx, kFactor * *middle);
  std::vector<std::string> names;
  for (const ImageOutcome& outcome : outcomes) {
    if (outcome.detection.hasCorners() && outcome.detection.measures.blur_px > limit)
      names.push_back(outcome.image);
  }
  if (names.empty()) return;
  constexpr std::size_t kMaxNamed = 5;
  const std::size_t num_more = names.size() - std::min(names.size(), kMaxNamed);
  names.resize(names.size() - num_more);
  notes.push_back("much more blurred than the others: " + join(names, ", ") +
                  (num_more > 0 ? " and " + std::to_string(num_more) + " more" : ""));
}

}  // namespace

std::vector<std::string> triage(std::span<ImageOutcome> outcomes, const Checkerboard& board) {
  std::vector<std::string> notes;
  refuseOtherSizes(outcomes, notes);
  refusePartsOfAnother(outcomes, board);
  refuseDuplicates(outcomes);
  noteBlurred(outcomes, notes);
  return notes;
}

std::optional<BoardHint> diagnoseBoard(std::span<const ImageOutcome> outcomes, const Checkerboard& asked) {
  // A board that was seen but not used for what it looks like is no other board.
  const auto speaks = [&](const Detection& detection) {
    switch (detection.reason) {
      case DetectionReason::kUnplaced:
      case DetectionReason::kLargerBoard:
      case DetectionReason::kOtherBoard:
        return detection.seen && !hasCountsOf(*detection.seen, asked);
      default:
        return false;
    }
  };
  std::optional<BoardHint> best;
  for (const bool is_closed : {true, false}) {
    std::map<std::pair<int, int>, int> counts;
    for (const ImageOutcome& outcome : outcomes) {
      const Detection& detection = outcome.detection;
      if (!speaks(detection) || detection.seen->is_closed != is_closed) continue;
      ++counts[{detection.seen->columns, detection.seen->rows}];
    }
    for (const auto& [size, count] : counts) {
      if (best && count <= best->num_images) continue;
      best =
          BoardHint{.columns = size.first, .rows = size.second, .num_images = count, .is_closed = is_closed};
    }
    if (best) break;
  }
  return best;
}

std::string hintText(const BoardHint& hint, const Checkerboard& asked) {
  // A hint has its longer side first; it is told in the order of the board that was asked for.
  const bool is_upright = asked.columns < asked.rows;
  const int columns = is_upright ? hint.rows : hint.columns;
  const int rows = is_upright ? hint.columns : hint.rows;
  std::string text = std::to_string(hint.num_images) +
                     (hint.num_images == 1 ? " image shows " : " images show ") +
                     (hint.is_closed ? "" : "at least ") + std::to_string(columns) + "x" +
                     std::to_string(rows) + " inner corners";
  if (columns + 1 == asked.columns && rows + 1 == asked.rows) text += "; did you count squares?";
  if (columns - 1 == asked.columns && rows - 1 == asked.rows)
    text += "; did you leave out a line of corners each way?";
  text += (text.back() == '?' ? " Use " : "; use ") +
          specText({.columns = columns, .rows = rows, .square_m = asked.square_m}) +
          (hint.is_closed ? " if that is the board" : " if that is all of the board");
  return text;
}

std::string ambiguityText(const Checkerboard& board) {
  if (!board.isAmbiguous()) return {};
  const std::string turned = board.symmetryStep() == 1 ? "90, 180 or 270" : "180";
  return "a board of " + std::to_string(board.columns) + "x" + std::to_string(board.rows) +
         " inner corners looks the same turned by " + turned +
         " degrees: which corner counts as the first is settled anew in each image, which one camera does "
         "not "
         "mind, but several cameras would; a board with one even and one odd count has no such doubt";
}

}  // namespace alidade
