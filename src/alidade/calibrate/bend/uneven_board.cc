// SPDX-License-Identifier: MIT
#include "alidade/calibrate/bend/uneven_board.h"

#include <cstddef>
#include <utility>
#include <vector>

#include "alidade/adjust/board/errors.h"
#include "alidade/adjust/board/solve.h"
#include "alidade/adjust/noise/board_offsets.h"
#include "alidade/adjust/noise/larger_model.h"

namespace alidade {
namespace {

constexpr double kWorthwhile = 0.05;  // of the held-out RMS

// As many boards as have few enough points in total.
std::vector<std::size_t> testableBoards(const Fit& fit) {
  constexpr int kMostPoints = 400;
  int num_points = 0;
  std::vector<std::size_t> boards;
  for (std::size_t b = 0; b < fit.boards.size(); ++b) {
    const int own = fit.boards[b].target.numCorners();
    if (numViews(fit, b) == 0 || num_points + own > kMostPoints) continue;
    num_points += own;
    boards.push_back(b);
  }
  return boards;
}

std::vector<std::size_t> allBoards(const Fit& fit) {
  std::vector<std::size_t> boards;
  for (std::size_t b = 0; b < fit.boards.size(); ++b) boards.push_back(b);
  return boards;
}

// The fit with offsets if the views confirm them.
std::optional<Fit> ifBorneOut(const Fit& even, UnevenReport& report, const CancelFlag* cancel) {
  const Fit started = startedUneven(even, testableBoards(even));
  // An improvement of held-out errors also shows in the errors of the fit.
  if (!isAnyUneven(started) || varianceLeftByOffsets(started) > (1 - kWorthwhile) * (1 - kWorthwhile))
    return std::nullopt;
  auto fit = withOffsets(started, OffsetScatter::kEstimate, cancel);
  if (!fit || !isAnyUneven(*fit)) return std::nullopt;
  const auto larger = betterModel(even, cancel);
  if (larger && larger->rms_px < weightedRms(*fit)) return std::nullopt;
  const auto of_even = heldOutErrors(even, cancel);
  const auto of_uneven = heldOutErrors(*fit, cancel);
  if (!of_even || !of_uneven) return std::nullopt;
  report.even_excess = excessOf(scoreOf(*of_even, even), scoreOf(*of_uneven, *fit));
  if (!report.even_excess->is_significant || !(report.even_excess->proven_share > kWorthwhile))
    return std::nullopt;
  return fit;
}

}  // namespace

UnevenFit uneven(SettledFit settled, BoardShapeMode mode, const CancelFlag* cancel) {
  UnevenFit result{.settled = std::move(settled), .report = {}};
  std::optional<Fit> fit;
  if (mode == BoardShapeMode::kAuto) fit = ifBorneOut(result.settled.fit, result.report, cancel);
  if (mode == BoardShapeMode::kUneven) {
    fit = withOffsets(startedUneven(result.settled.fit, allBoards(result.settled.fit)),
                      OffsetScatter::kEstimate, cancel);
    result.report.is_undetermined = !fit || !isAnyUneven(*fit);
  }
  if (!fit) return result;
  // Part of the apparent noise was the board.
  result.settled = unevenAgain(settledWeights(*std::move(fit), cancel), cancel);
  return result;
}

SettledFit unevenAgain(SettledFit settled, const CancelFlag* cancel) {
  auto fit = withOffsets(settled.fit, OffsetScatter::kEstimate, cancel);
  if (fit) {
    settled.fit = *std::move(fit);
    return settled;
  }
  // Offsets that do not converge are discarded.
  for (FitBoard& board : settled.fit.boards) makeEven(board);
  settled.fit = solve(std::move(settled.fit), {.cancel = cancel});
  return settled;
}

}  // namespace alidade
