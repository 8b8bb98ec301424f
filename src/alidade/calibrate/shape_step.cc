// SPDX-License-Identifier: MIT
#include "alidade/calibrate/shape_step.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>

#include "alidade/calibrate/covariance.h"
#include "alidade/calibrate/larger_model.h"
#include "alidade/calibrate/robust_weighting.h"
#include "alidade/calibrate/shape_information.h"

namespace alidade {
namespace {

constexpr double kFlatTolerance = 1e-9;  // of the cost: far below a difference that counts

std::optional<ShapeInformation> information(const Estimation& e) {
  return shapeInformation(e.options.model, e.board, e.observations, e.state, e.loss, e.constraint,
                          e.weak_prior.prior);
}

std::optional<BendByViews> byViews(const Estimation& e, const ShapeInformation& info) {
  const Eigen::Vector2d bend_m(e.shape.shape.bend_x_m, e.shape.shape.bend_y_m);
  return bendByViews(info, bend_m + info.step_m,
                     freeDirections(static_cast<int>(e.state.params.size()), e.constraint),
                     meanSlope(weightedErrors(e), e.loss));
}

// Twice the cost by the degrees of freedom that are left with the bend free: the variance of a coordinate.
double varianceLeft(const Estimation& e, double drop) {
  std::size_t num_corners = 0;
  for (const auto& view : e.observations) num_corners += view.size();
  const double freedom = 2.0 * static_cast<double>(num_corners) - static_cast<double>(e.state.params.size()) -
                         6.0 * static_cast<double>(e.views.size()) - kNumBends;
  const double floor = 2 * kMinSigmaPx * kMinSigmaPx * static_cast<double>(num_corners);
  return std::max(2 * e.summary.cost - drop, floor) / freedom;
}

void bend(Estimation& e, const Eigen::Vector2d& step_m) {
  e.shape.shape.bend_x_m += step_m.x();
  e.shape.shape.bend_y_m += step_m.y();
  for (auto& view : e.observations) {
    for (Observation& o : view) o.p_board = onBentBoard(e.board, e.shape.shape, o.p_board);
  }
}

void flatten(Observations& views) {
  for (auto& view : views) {
    for (Observation& o : view) o.p_board.z() = 0;
  }
}

void takeAsFlat(Estimation& e, BundleState state) {
  e.shape.shape = {};
  e.shape.is_estimated = false;
  e.shape.flat_params.clear();
  e.shape.flat_rms_px = std::numeric_limits<double>::quiet_NaN();
  e.state = std::move(state);
  flatten(e.observations);
}

// Steps until the cost has nothing left to gain. The cost is a parabola of the bend but for the poses, which
// follow: two or three steps do. False where the views do not determine the bend after all.
bool stepToRest(Estimation& e) {
  constexpr double kAtRest = 1e-12;  // of twice the cost
  for (int round = 0; round < kMaxRounds; ++round) {
    const auto info = information(e);
    if (!info) {
      e.shape.is_determined = false;
      return false;
    }
    const double variance = varianceLeft(e, info->drop);
    e.shape.std_m = (variance * info->bend_inverse.diagonal()).cwiseSqrt();
    e.shape.by_views = byViews(e, *info);
    if (info->drop <= kAtRest * 2 * e.summary.cost) return true;
    bend(e, info->step_m);
    solve(e);
  }
  e.is_settled = false;
  return true;
}

}  // namespace

void estimateShape(Estimation& e) {
  if (e.options.board_shape == BoardShapeMode::kFlat) return;
  e.shape.is_requested = e.options.board_shape == BoardShapeMode::kWarp;
  const auto info = information(e);
  if (!info) {
    e.shape.is_determined = false;
    return;
  }
  const double variance = varianceLeft(e, info->drop);
  e.shape.f = info->drop / kNumBends / variance;
  e.shape.std_m = (variance * info->bend_inverse.diagonal()).cwiseSqrt();
  e.shape.by_views = byViews(e, *info);
  if (e.options.board_shape == BoardShapeMode::kAuto && !isBent(e.shape.f, e.shape.by_views)) return;
  const auto larger = e.options.board_shape == BoardShapeMode::kAuto ? betterModel(e) : std::nullopt;
  const BundleState flat = e.state;
  e.shape.is_estimated = true;
  e.shape.flat_params = e.state.params;
  bend(e, info->step_m);
  solve(e);
  // What looked like noise was the bend: weights and loss are settled anew.
  settleWeights(e);
  const bool is_determined = stepToRest(e);
  // A bend takes up some of what a model lacks. If the larger model explains more than the bend, it is that.
  if (!is_determined || (larger && larger->rms_px < std::sqrt(meanWeightedSquare(e)))) {
    takeAsFlat(e, flat);
    solve(e);
    settleWeights(e);
  }
}

bool refineShape(Estimation& e) {
  if (!e.shape.is_estimated) return true;
  const bool is_determined = stepToRest(e);
  BundleState flat = e.state;
  flat.params = e.shape.flat_params;
  Observations views = e.observations;
  flatten(views);
  const BundleSummary summary = solveBundle(e.options.model, views, flat,
                                            {.loss = e.loss,
                                             .function_tolerance = kFlatTolerance,
                                             .constraint = e.constraint,
                                             .prior = e.weak_prior.prior,
                                             .cancel = e.options.cancel});
  const double drop = 2 * (summary.cost - e.summary.cost);
  e.shape.f = drop / kNumBends / varianceLeft(e, 0);
  e.shape.flat_params = flat.params;
  e.shape.flat_rms_px = weightedRms(e.options.model, views, flat);
  if (is_determined &&
      (e.options.board_shape == BoardShapeMode::kWarp || isBent(e.shape.f, e.shape.by_views)))
    return true;
  // What looked like a bend was outliers.
  takeAsFlat(e, std::move(flat));
  solve(e);
  return false;
}

void noteIgnoredBend(Estimation& e) {
  if (e.options.board_shape != BoardShapeMode::kFlat) return;
  const auto info = information(e);
  if (!info) return;
  const double f = info->drop / kNumBends / varianceLeft(e, info->drop);
  if (!isBent(f, byViews(e, *info))) return;
  e.shape.ignored = IgnoredBend{.shape = {.bend_x_m = info->step_m.x(), .bend_y_m = info->step_m.y()},
                                .params_step = info->params_step,
                                .cost_share = 1 - info->drop / (2 * e.summary.cost)};
}

}  // namespace alidade
