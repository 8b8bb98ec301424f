// SPDX-License-Identifier: MIT
#include "alidade/calibrate/bend/flex_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include <Eigen/LU>

#include "alidade/adjust/board/errors.h"
#include "alidade/adjust/board/reduced.h"
#include "alidade/adjust/board/solve.h"
#include "alidade/adjust/noise/board_offsets.h"
#include "alidade/adjust/noise/larger_model.h"
#include "alidade/adjust/noise/view_ways.h"
#include "alidade/geometry/decompositions.h"

namespace alidade {
namespace {

bool isFlexing(const Fit& fit) {
  constexpr std::size_t kFewestViews = 5;
  constexpr double kF = 8;      // of 640 sets with other flaws, one exceeds 6 with this ratio and none 20
  constexpr double kRatio = 4;  // of sets with other flaws: up to 1.6; of flexing boards: 15 or more
  if (fit.views.size() < kFewestViews) return false;
  const ViewWays ways(fit);
  if (!ways.isRedundant(4)) return false;
  const WayDrop all = ways.dropBy(kRowAndBendWays);
  const double bends_f = ways.f(all, ways.dropBy(kRowWays));
  const double rows_f = ways.f(all, ways.dropBy(kBendWays));
  return bends_f > kF && bends_f > kRatio * rows_f;
}

// The views of each placement of a board.
std::vector<std::vector<FitView*>> viewsByPlacement(std::size_t board, Fit& fit) {
  std::vector<std::vector<FitView*>> views(fit.placements.size());
  for (FitView& view : fit.views) {
    if (view.board == board) views[view.placement].push_back(&view);
  }
  std::erase_if(views, [](const auto& of_placement) { return of_placement.empty(); });
  return views;
}

// The equations of the bends in one placement, with its pose eliminated and the cameras held.
Reduced bendEquations(const Fit& fit, const std::vector<FitView*>& views) {
  constexpr Eigen::Index kOwn = 6 + kNumBends;
  Eigen::Matrix<double, kOwn + 1, kOwn + 1> sums = Eigen::Matrix<double, kOwn + 1, kOwn + 1>::Zero();
  for (const FitView* view : views) {
    const FitCamera& camera = fit.cameras[view->camera];
    const Eigen::MatrixXd gram =
        detail::gramOf(camera.model, camera.params, cameraFromBoard(fit, *view), cornersOnShape(fit, *view),
                       fit.loss, LossWeights::kUse, bendColumns(&boardOf(fit, *view).target))
            .lower;
    // Without the columns of the parameters.
    const Eigen::Index rest = gram.rows() - (kOwn + 1 - 6);
    sums.topLeftCorner<6, 6>() += gram.topLeftCorner<6, 6>();
    sums.bottomLeftCorner<kNumBends + 1, 6>() += gram.block<kNumBends + 1, 6>(rest, 0);
    sums.bottomRightCorner<kNumBends + 1, kNumBends + 1>() +=
        gram.block<kNumBends + 1, kNumBends + 1>(rest, rest);
  }
  const Eigen::MatrixXd pose = sums.topLeftCorner<6, 6>().selfadjointView<Eigen::Lower>();
  const Eigen::MatrixXd coupling = sums.bottomLeftCorner<kNumBends + 1, 6>().transpose();
  const Eigen::MatrixXd whole =
      sums.bottomRightCorner<kNumBends + 1, kNumBends + 1>().selfadjointView<Eigen::Lower>();
  const Eigen::MatrixXd left = whole - coupling.transpose() * solveSpd(pose, coupling);
  return {.information = left.topLeftCorner<kNumBends, kNumBends>(),
          .gradient = left.topRightCorner<kNumBends, 1>()};
}

// Where the board's own bend is estimated, the mean of the others is zero at the optimum.
void centre(const std::vector<std::vector<FitView*>>& views, FitBoard& board) {
  if (board.is_shape_fixed) return;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const auto& of_placement : views)
    mean += of_placement.front()->flex_m / static_cast<double>(views.size());
  for (const auto& of_placement : views) {
    for (FitView* view : of_placement) view->flex_m -= mean;
  }
  board.shape.bend_x_m += mean.x();
  board.shape.bend_y_m += mean.y();
}

// The same as updateFlex() for one board.
double updateFlexOf(std::size_t b, Fit& fit) {
  FitBoard& board = fit.boards[b];
  Flex& flex = board.flex;
  const double variance = noiseSigma(fit) * noiseSigma(fit);
  double squares = 0;
  double largest = 0;
  flex.num_free = 0;
  const std::vector<std::vector<FitView*>> views = viewsByPlacement(b, fit);
  for (const std::vector<FitView*>& of_placement : views) {
    const Reduced bends = bendEquations(fit, of_placement);
    const Eigen::Matrix2d inverse =
        (bends.information + flex.precision * Eigen::Matrix2d::Identity()).inverse();
    const Eigen::Vector2d from = of_placement.front()->flex_m;
    const Eigen::Vector2d step = -inverse * (bends.gradient + flex.precision * from);
    if (!step.allFinite()) continue;
    for (FitView* view : of_placement) view->flex_m = from + step;
    largest =
        std::max(largest, (step.array() / (variance * inverse.diagonal()).array().sqrt()).abs().maxCoeff());
    flex.num_free += (inverse * bends.information).trace();
  }
  centre(views, board);
  for (const auto& of_placement : views) squares += of_placement.front()->flex_m.squaredNorm();
  flex.std_m = std::sqrt(squares / std::max(1.0, flex.num_free));
  flex.precision = variance / (flex.std_m * flex.std_m);
  if (!std::isfinite(flex.precision)) {
    flex = {};
    for (const auto& of_placement : views) {
      for (FitView* view : of_placement) view->flex_m.setZero();
    }
    return 0;
  }
  return largest;
}

void iterate(SettledFit& now, const CancelFlag* cancel) {
  const bool was_settled = now.is_settled;
  for (int round = 0; round < kMostFlexSteps; ++round) {
    const double moved = updateFlex(now.fit);
    now = settledWeights(std::move(now.fit), cancel);
    now.is_settled = now.is_settled && was_settled;
    if (moved < kFlexAtRest) return;
  }
  now.is_settled = false;
}

}  // namespace

double updateFlex(Fit& fit) {
  double largest = 0;
  for (std::size_t b = 0; b < fit.boards.size(); ++b) {
    if (fit.boards[b].isFlexible()) largest = std::max(largest, updateFlexOf(b, fit));
  }
  return largest;
}

void estimateFlex(SettledFit& now, BoardShapeMode mode, const CancelFlag* cancel) {
  constexpr double kStartShare = 0.01;  // of the board's size
  const bool is_tested = mode == BoardShapeMode::kAuto;
  if (is_tested ? now.fit.boards.size() != 1 || isAnyUneven(now.fit) || !isFlexing(now.fit)
                : mode != BoardShapeMode::kFlexible)
    return;
  const auto larger = is_tested ? betterModel(now.fit, cancel) : std::nullopt;
  const SettledFit rigid = now;
  for (FitBoard& board : now.fit.boards) {
    board.flex.std_m = kStartShare * board.target.span().maxCoeff();
    board.flex.precision = std::pow(noiseSigma(now.fit) / board.flex.std_m, 2);
  }
  iterate(now, cancel);
  if (!is_tested) return;
  // Bends absorb part of what the model lacks, or of points that are off their places in all views. If a
  // larger model or such points explain more, these are at fault.
  const double rms_px = weightedRms(now.fit);
  constexpr std::array<std::size_t, 1> kOnlyBoard = {0};
  constexpr int kMostPoints = 400;
  if ((larger && larger->rms_px < rms_px) ||
      (onlyBoard(rigid.fit).target.numCorners() <= kMostPoints &&
       std::sqrt(varianceLeftByOffsets(startedUneven(rigid.fit, kOnlyBoard))) * weightedRms(rigid.fit) <
           rms_px))
    now = rigid;
}

void estimateFlexAgain(SettledFit& now, BoardShapeMode mode, const CancelFlag* cancel) {
  if (!isAnyFlexible(now.fit)) return;
  if (mode == BoardShapeMode::kFlexible) return iterate(now, cancel);
  Fit rigid = now.fit;
  stiffen(rigid);
  rigid = solve(std::move(rigid), {.cancel = cancel});
  if (isFlexing(rigid)) return iterate(now, cancel);
  const bool was_settled = now.is_settled;
  now = settledWeights(std::move(rigid), cancel);
  now.is_settled = now.is_settled && was_settled;
}

}  // namespace alidade
