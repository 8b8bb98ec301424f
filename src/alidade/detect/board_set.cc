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

// The markers of a board: ids of a family in which every id has one pattern.
struct MarkerIds {
  std::string family;
  int first = 0;
  int last = 0;
};

// OpenCV's smaller dictionaries are the first markers of larger ones: "DICT_4X4" for "DICT_4X4_50".
std::string familyOf(const std::string& dictionary) {
  const bool is_sized = dictionary.find("X") != std::string::npos;
  return is_sized ? dictionary.substr(0, dictionary.rfind('_')) : dictionary;
}

std::optional<MarkerIds> markersOf(const Board& board) {
  if (const auto* grid = std::get_if<AprilGrid>(&board.kind())) {
    return MarkerIds{.family = std::string(AprilGrid::kDictionary),
                     .first = grid->first_id,
                     .last = grid->first_id + grid->columns * grid->rows - 1};
  }
  if (const auto* charuco = std::get_if<CharucoBoard>(&board.kind()))
    return MarkerIds{.family = familyOf(charuco->dictionary), .last = charuco->numMarkers(true) - 1};
  return std::nullopt;
}

bool haveSameCounts(const Board& a, const Board& b) {
  return std::minmax(a.columns(), a.rows()) == std::minmax(b.columns(), b.rows());
}

// Squares are seen in both kinds; discs in rows and discs in staggered rows differ.
bool haveSamePattern(const Board& a, const Board& b) {
  const auto hasSquares = [](const Board& board) {
    return std::holds_alternative<Checkerboard>(board.kind()) ||
           std::holds_alternative<CharucoBoard>(board.kind());
  };
  return a.kind().index() == b.kind().index() || (hasSquares(a) && hasSquares(b));
}

// Why images cannot tell two boards apart, and what to do about it.
std::optional<BoardLikeness> likenessOf(const Board& a, const Board& b) {
  if (a == b) return BoardLikeness{.reason = "the same board twice", .next_step = "give each board once"};
  const auto markers = markersOf(a);
  const auto others = markersOf(b);
  if (markers && others) {
    const int first = std::max(markers->first, others->first);
    const int last = std::min(markers->last, others->last);
    if (markers->family != others->family || first > last) return std::nullopt;
    const bool are_grids =
        std::holds_alternative<AprilGrid>(a.kind()) && a.kind().index() == b.kind().index();
    return BoardLikeness{
        .reason =
            fmt::format("two boards with the same markers, ids {} to {} of {}", first, last, markers->family),
        .next_step = are_grids
                         ? "print one of them with another first id (the last part of the SPEC), or "
                           "calibrate with one board only"
                         : "print one of them with another dictionary, or calibrate with one board only"};
  }
  if (!haveSamePattern(a, b) || !haveSameCounts(a, b)) return std::nullopt;
  return BoardLikeness{
      .reason = "two boards with the same numbers of corners",
      .next_step = "use boards with different counts, or boards with markers (charuco, aprilgrid)"};
}

// Corners of both that lie at the same place.
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

// What a board's claim is worth: more with markers, then if the board is whole.
int rankOf(const Board& board, const Detection& detection) {
  return markersOf(board) ? 2 : detection.found() ? 1 : 0;
}

}  // namespace

std::optional<BoardLikeness> findLikeness(std::span<const Board> boards) {
  for (std::size_t b = 0; b < boards.size(); ++b) {
    for (std::size_t a = 0; a < b; ++a) {
      if (auto likeness = likenessOf(boards[a], boards[b])) {
        likeness->boards = fmt::format("boards {} and {}", boards[a].spec(), boards[b].spec());
        return likeness;
      }
    }
  }
  return std::nullopt;
}

void requireDistinguishable(std::span<const Board> boards) {
  const auto likeness = findLikeness(boards);
  if (!likeness) return;
  throw usageError({.where = likeness->boards,
                    .found = likeness->reason,
                    .expected = "boards that images can tell apart, by markers or by counts",
                    .next_step = likeness->next_step});
}

void settleClaims(std::span<const Board> boards, std::span<std::vector<ImageOutcome>> outcomes) {
  constexpr std::size_t kContested = 4;  // fewer may be neighbours by chance
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
