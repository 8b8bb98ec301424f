// SPDX-License-Identifier: MIT
#include "alidade/calibrate/bend/flex_fit.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/LU>

#include "alidade/adjust/board/errors.h"
#include "alidade/adjust/board/reduced.h"
#include "alidade/adjust/board/solve.h"
#include "alidade/adjust/noise/larger_model.h"
#include "alidade/adjust/noise/view_ways.h"

namespace alidade {
namespace {

bool isFlexing(const Fit& fit) {
  constexpr std::size_t kFewestViews = 5;
  constexpr double kF = 20;     // of sets with other flaws: up to 16
  constexpr double kRatio = 4;  // of sets with other flaws: up to 1.6; of flexing boards: 15 or more
  if (fit.views.size() < kFewestViews) return false;
  const ViewWays ways(fit);
  if (!ways.isRedundant(4)) return false;
  const WayDrop all = ways.dropBy(kRowAndBendWays);
  const double bends_f = ways.f(all, ways.dropBy(kRowWays));
  const double rows_f = ways.f(all, ways.dropBy(kBendWays));
  return bends_f > kF && bends_f > kRatio * rows_f;
}

// Where the board's own bend is estimated, the mean of the others is zero at the optimum.
void centre(Fit& fit) {
  FitBoard& board = fit.boards.front();
  if (board.is_shape_fixed) return;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const FitView& view : fit.views) mean += view.flex_m / static_cast<double>(fit.views.size());
  for (FitView& view : fit.views) view.flex_m -= mean;
  board.shape.bend_x_m += mean.x();
  board.shape.bend_y_m += mean.y();
}

// Moves the bends of all views to their optimum with the intrinsics held, and estimates their scatter.
// Returns the largest step in standard deviations of the bend itself. A board without scatter becomes rigid.
double updateFlex(Fit& fit) {
  Flex& flex = fit.boards.front().flex;
  const double variance = noiseSigma(fit) * noiseSigma(fit);
  double squares = 0;
  double largest = 0;
  flex.num_free = 0;
  for (FitView& view : fit.views) {
    const Reduced of_view =
        reducedByPose(fit, view, LossWeights::kUse, bendColumns(&boardOf(fit, view).target));
    const Eigen::Matrix2d information = of_view.information.bottomRightCorner<kNumBends, kNumBends>();
    const Eigen::Matrix2d inverse = (information + flex.precision * Eigen::Matrix2d::Identity()).inverse();
    const Eigen::Vector2d step =
        -inverse * (of_view.gradient.tail<kNumBends>() + flex.precision * view.flex_m);
    if (step.allFinite()) {
      view.flex_m += step;
      largest =
          std::max(largest, (step.array() / (variance * inverse.diagonal()).array().sqrt()).abs().maxCoeff());
      flex.num_free += (inverse * information).trace();
    }
  }
  centre(fit);
  for (const FitView& view : fit.views) squares += view.flex_m.squaredNorm();
  flex.std_m = std::sqrt(squares / std::max(1.0, flex.num_free));
  flex.precision = variance / (flex.std_m * flex.std_m);
  if (!std::isfinite(flex.precision)) {
    stiffen(fit);
    return 0;
  }
  return largest;
}

void iterate(SettledFit& now, const CancelFlag* cancel) {
  constexpr int kMostRounds = 100;
  constexpr double kAtRest = 0.01;  // standard deviations
  const bool was_settled = now.is_settled;
  for (int round = 0; round < kMostRounds; ++round) {
    const double moved = updateFlex(now.fit);
    now = settledWeights(std::move(now.fit), cancel);
    now.is_settled = now.is_settled && was_settled;
    if (moved < kAtRest) return;
  }
  now.is_settled = false;
}

}  // namespace

void estimateFlex(SettledFit& now, BoardShapeMode mode, const CancelFlag* cancel) {
  if (mode != BoardShapeMode::kAuto || now.fit.boards.size() != 1 || isAnyUneven(now.fit) ||
      !isFlexing(now.fit))
    return;
  constexpr double kStartShare = 0.01;  // of the board's size
  const auto larger = betterModel(now.fit, cancel);
  const SettledFit rigid = now;
  FitBoard& board = now.fit.boards.front();
  board.flex.std_m = kStartShare * board.target.span().maxCoeff();
  board.flex.precision = std::pow(noiseSigma(now.fit) / board.flex.std_m, 2);
  iterate(now, cancel);
  // Bends absorb part of what the model lacks. If a larger model explains more, the model is at fault.
  if (larger && larger->rms_px < weightedRms(now.fit)) now = rigid;
}

void estimateFlexAgain(SettledFit& now, const CancelFlag* cancel) {
  if (!now.fit.boards.front().isFlexible()) return;
  Fit rigid = now.fit;
  stiffen(rigid);
  rigid = solve(std::move(rigid), {.cancel = cancel});
  if (isFlexing(rigid)) return iterate(now, cancel);
  const bool was_settled = now.is_settled;
  now = settledWeights(std::move(rigid), cancel);
  now.is_settled = now.is_settled && was_settled;
}

}  // namespace alidade
