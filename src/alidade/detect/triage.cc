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

void refuseOtherSizes(std::span<ImageOutcome> outcomes, std::vector<SurveyNote>& notes) {
  const bool any_corners =
      std::any_of(outcomes.begin(), outcomes.end(), [](const auto& o) { return o.detection.hasCorners(); });
  // Images without the board have no say in its size, unless there are no others.
  std::vector<ImageSize> sizes;
  std::vector<std::size_t> voters;
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    const Detection& detection = outcomes[i].detection;
    const bool is_readable = detection.reason != DetectionReason::kUnreadable;
    if (!(any_corners ? detection.hasCorners() : is_readable)) continue;
    sizes.push_back(outcomes[i].size);
    voters.push_back(i);
  }
  const SizeGroups groups = groupBySize(sizes);
  for (ImageOutcome& outcome : outcomes) {
    if (outcome.detection.reason == DetectionReason::kUnreadable || outcome.size == groups.size) continue;
    withdraw(outcome.detection, DetectionReason::kOtherSize,
             "is " + sizeText(outcome.size) + ", while most images are " + sizeText(groups.size));
  }
  if (groups.others.empty()) return;
  SurveyNote note{
      .kind = SurveyNote::Kind::kSeveralSizes, .size = groups.size, .num_used = groups.in_group.size()};
  for (const std::size_t k : groups.others) note.images.push_back(voters[k]);
  notes.push_back(std::move(note));
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
      outcomes[i].same_as = original;
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
    refuseUnclosed(outcomes, "may show part of the board of " + std::to_string(hint->columns) + "x" +
                                 std::to_string(hint->rows) +
                                 " inner corners that is completely visible in other images");
    return;
  }
  constexpr int kEnoughImages = 3;
  if (num_all_lines > 0 || num_with_corners < kEnoughImages) return;
  const auto commonest = std::max_element(counts.begin(), counts.end(),
                                          [](const auto& a, const auto& b) { return a.second < b.second; });
  if (2 * commonest->second <= num_with_corners) return;
  refuseUnclosed(outcomes, "no image shows all rows and columns of a board with " +
                               std::to_string(board.columns) + "x" + std::to_string(board.rows) +
                               " inner corners; most show " + std::to_string(commonest->first.first) + "x" +
                               std::to_string(commonest->first.second));
}

// Images whose edges are much wider than those of most; their corners are used, with their large sigmas.
void noteBlurred(std::span<const ImageOutcome> outcomes, std::vector<SurveyNote>& notes) {
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
  SurveyNote note{.kind = SurveyNote::Kind::kBlurred};
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    if (outcomes[i].detection.hasCorners() && outcomes[i].detection.measures.blur_px > limit)
      note.images.push_back(i);
  }
  if (!note.images.empty()) notes.push_back(std::move(note));
}

}  // namespace

std::vector<SurveyNote> triage(std::span<ImageOutcome> outcomes, const Checkerboard& board) {
  std::vector<SurveyNote> notes;
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

}  // namespace alidade
