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
std::optional<ErrorDetail> likenessOf(const Board& a, const Board& b) {
  if (a == b) return ErrorDetail{.found = "the same board twice", .next_step = "give each board once"};
  const auto markers = a.markers();
  const auto others = b.markers();
  if (markers && others) {
    const int first = std::max(markers->first, others->first);
    const int last = std::min(markers->last, others->last);
    if (markers->family != others->family || first > last) return std::nullopt;
    return ErrorDetail{
        .found =
            fmt::format("two boards with the same markers, ids {} to {} of {}", first, last, markers->family),
        .next_step =
            "print one of them with another first id (the last part of the SPEC), or calibrate with "
            "one board only"};
  }
  if (a.pattern() != b.pattern() || !haveSameCounts(a, b)) return std::nullopt;
  return ErrorDetail{
      .found = fmt::format("two boards with the same numbers of {}", a.words().points),
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

// Priority of a board's claim: higher with markers, then if the board is complete.
int rankOf(const Board& board, const Detection& detection) {
  return board.markers() ? 2 : detection.found() ? 1 : 0;
}

}  // namespace

void requireDistinguishable(std::span<const Board> boards) {
  for (std::size_t b = 0; b < boards.size(); ++b) {
    for (std::size_t a = 0; a < b; ++a) {
      auto likeness = likenessOf(boards[a], boards[b]);
      if (!likeness) continue;
      likeness->where = fmt::format("boards {} and {}", boards[a].spec(), boards[b].spec());
      likeness->expected = "boards that images can tell apart, by markers or by counts";
      throw usageError(*likeness);
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
        const auto withdraw = [](Detection& detection, bool is_certain, const Board& other) {
          detection.withdraw(DetectionReason::kUnplaced,
                             fmt::format("its corners {} {}",
                                         is_certain ? "are those of" : "may also be those of", other.spec()));
        };
        if (first_rank <= second_rank) withdraw(first, first_rank < second_rank, boards[b]);
        if (second_rank <= first_rank) withdraw(second, second_rank < first_rank, boards[a]);
      }
    }
  }
}

}  // namespace alidade
