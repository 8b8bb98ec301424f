// SPDX-License-Identifier: MIT
#include "alidade/detect/board_set.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "alidade/core/error.h"

namespace alidade {
namespace {

bool haveSameCounts(const Board& a, const Board& b) {
  return std::minmax(a.columns(), a.rows()) == std::minmax(b.columns(), b.rows());
}

// The reason why images cannot distinguish two boards, and the remedy.
struct Likeness {
  std::string reason;
  std::string next_step;
};

std::optional<Likeness> likenessOf(const Board& a, const Board& b) {
  if (a == b) return Likeness{.reason = "the same board twice", .next_step = "give each board once"};
  const auto markers = a.markers();
  const auto others = b.markers();
  if (markers && others) {
    const int first = std::max(markers->first, others->first);
    const int last = std::min(markers->last, others->last);
    if (markers->family != others->family || first > last) return std::nullopt;
    const bool are_of_one_kind = a.kind().index() == b.kind().index();
    return Likeness{
        .reason =
            fmt::format("two boards with the same markers, ids {} to {} of {}", first, last, markers->family),
        .next_step = fmt::format("print one of them with {}, or calibrate with one board only",
                                 are_of_one_kind ? a.words().other_markers : "another dictionary")};
  }
  if (a.pattern() != b.pattern() || !haveSameCounts(a, b)) return std::nullopt;
  return Likeness{
      .reason = fmt::format("two boards with the same numbers of {}", a.words().points),
      .next_step = "use boards with different counts, or boards with markers (charuco, aprilgrid)"};
}

// Number of corners of both lists that lie at the same place.
std::size_t numShared(const std::vector<Corner>& a, const std::vector<Corner>& b) {
  constexpr double kSamePx = 2;
  return static_cast<std::size_t>(std::ranges::count_if(a, [&](const Corner& corner) {
    return std::ranges::any_of(b, [&](const Corner& other) {
      return (corner.pixel - other.pixel).squaredNorm() < kSamePx * kSamePx;
    });
  }));
}

void withdrawAs(Detection& detection, std::string detail) {
  detection.reason = DetectionReason::kUnplaced;
  detection.detail = std::move(detail);
  detection.corners.clear();
}

// Priority of a board's claim: higher with markers, then if the board is complete.
int rankOf(const Board& board, const Detection& detection) {
  return board.markers() ? 2 : detection.found() ? 1 : 0;
}

}  // namespace

void requireDistinguishable(std::span<const Board> boards) {
  for (std::size_t b = 0; b < boards.size(); ++b) {
    for (std::size_t a = 0; a < b; ++a) {
      const auto likeness = likenessOf(boards[a], boards[b]);
      if (!likeness) continue;
      throw usageError({.where = fmt::format("boards {} and {}", boards[a].spec(), boards[b].spec()),
                        .found = likeness->reason,
                        .expected = "boards that images can tell apart, by markers or by counts",
                        .next_step = likeness->next_step});
    }
  }
}

void settleClaims(std::span<const Board> boards, std::span<std::vector<ImageOutcome>> outcomes) {
  constexpr std::size_t kContested = 4;  // fewer may coincide by chance
  for (std::size_t b = 0; b < boards.size(); ++b) {
    for (std::size_t a = 0; a < b; ++a) {
      for (std::size_t i = 0; i < outcomes[a].size(); ++i) {
        Detection& first = outcomes[a][i].detection;
        Detection& second = outcomes[b][i].detection;
        if (numShared(first.corners, second.corners) < kContested) continue;
        const int first_rank = rankOf(boards[a], first);
        const int second_rank = rankOf(boards[b], second);
        if (first_rank <= second_rank) {
          withdrawAs(first, fmt::format("its corners {} {}",
                                        first_rank < second_rank ? "are those of" : "may also be those of",
                                        boards[b].spec()));
        }
        if (second_rank <= first_rank) {
          withdrawAs(second, fmt::format("its corners {} {}",
                                         second_rank < first_rank ? "are those of" : "may also be those of",
                                         boards[a].spec()));
        }
      }
    }
  }
}

}  // namespace alidade
