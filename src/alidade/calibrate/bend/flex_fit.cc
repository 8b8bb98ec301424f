// SPDX-License-Identifier: MIT
#include "alidade/calibrate/bend/flex_fit.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/LU>

#include "alidade/adjust/board/reduced.h"
#include "alidade/adjust/noise/view_ways.h"

namespace alidade {
namespace {

bool isFlexing(const Fit& fit) {
  constexpr std::size_t kFewestViews = 5;
  constexpr double kF = 20;     // of sets with other flaws: up to 16
  constexpr double kRatio = 4;  // of sets with other flaws: up to 1.6; of flexing boards: 15 or more
  if (fit.views.size() < kFewestViews) return false;
  const ViewWays ways(fit);
  if (!ways.isRedundant()) return false;
  const WayDrop all = ways.dropBy(kRowAndBendWays);
  const double bends_f = ways.f(all, ways.dropBy(kRowWays));
  const double rows_f = ways.f(all, ways.dropBy(kBendWays));
  return bends_f > kF && bends_f > kRatio * rows_f;
}

// Moves the bends of all views to their optimum with the intrinsics held, and estimates their scatter.
// Returns the largest step as a share of it.
double updateFlex(Fit& fit) {
  FitBoard& board = fit.boards.front();
  const double variance = noiseSigma(fit) * noiseSigma(fit);
  double squares = 0;
  double largest_m = 0;
  board.num_free_flexes = 0;
  for (FitView& view : fit.views) {
    const Reduced of_view = reducedByPose(fit, view, LossWeights::kUse, bendColumns(&board.target));
    const Eigen::Matrix2d information = of_view.information.bottomRightCorner<kNumBends, kNumBends>();
    const Eigen::Matrix2d prior = board.flex_precision * Eigen::Matrix2d::Identity();
    const Eigen::Matrix2d inverse = (information + prior).inverse();
    const Eigen::Vector2d step =
        -inverse * (of_view.gradient.tail<kNumBends>() + board.flex_precision * view.flex_m);
    if (!step.allFinite()) continue;
    view.flex_m += step;
    largest_m = std::max(largest_m, step.cwiseAbs().maxCoeff());
    squares += view.flex_m.squaredNorm();
    board.num_free_flexes += (inverse * information).trace();
  }
  board.flex_std_m = std::sqrt(squares / std::max(1.0, board.num_free_flexes));
  board.flex_precision = variance / (board.flex_std_m * board.flex_std_m);
  return largest_m / board.flex_std_m;
}

}  // namespace

void estimateFlex(SettledFit& now, BoardShapeMode mode, const CancelFlag* cancel) {
  if (mode != BoardShapeMode::kAuto || now.fit.boards.size() != 1 || isAnyUneven(now.fit) ||
      !isFlexing(now.fit))
    return;
  constexpr double kStartShare = 0.01;  // of the board's size
  FitBoard& board = now.fit.boards.front();
  board.flex_std_m = kStartShare * board.target.span().maxCoeff();
  board.flex_precision = std::pow(noiseSigma(now.fit) / board.flex_std_m, 2);
  estimateFlexAgain(now, cancel);
}

void estimateFlexAgain(SettledFit& now, const CancelFlag* cancel) {
  if (!now.fit.boards.front().isFlexible()) return;
  constexpr int kMostRounds = 50;
  constexpr double kAtRest = 1e-3;  // of the scatter
  for (int round = 0; round < kMostRounds; ++round) {
    const double moved = updateFlex(now.fit);
    now = settledWeights(std::move(now.fit), cancel);
    if (moved < kAtRest) return;
  }
  now.is_settled = false;
}

}  // namespace alidade
