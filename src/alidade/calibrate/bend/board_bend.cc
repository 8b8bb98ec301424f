// SPDX-License-Identifier: MIT
#include "alidade/calibrate/bend/board_bend.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/LU>

#include "alidade/adjust/covariance.h"
#include "alidade/adjust/errors.h"
#include "alidade/adjust/larger_model.h"
#include "alidade/adjust/solve.h"
#include "alidade/adjust/view_shares.h"
#include "alidade/core/statistics.h"

namespace alidade {
namespace {

std::optional<BendByViews> byViews(const Fit& fit, const ShapeInformation& info) {
  const FitCamera& camera = onlyCamera(fit);
  const BoardShape& shape = onlyBoard(fit).shape;
  return bendByViews(info, Eigen::Vector2d(shape.bend_x_m, shape.bend_y_m) + info.step_m,
                     freeDirections(static_cast<int>(camera.params.size()), camera.constraint),
                     meanSlope(weightedErrors(fit), fit.loss));
}

// Twice the cost by the degrees of freedom that are left with the bend free: the variance of a coordinate.
double varianceLeft(const Fit& fit, double drop) {
  const auto num_corners = static_cast<double>(numCorners(fit));
  const double freedom = 2.0 * num_corners - static_cast<double>(onlyCamera(fit).params.size()) -
                         6.0 * static_cast<double>(fit.views.size()) - kNumBends;
  const double floor = 2 * kMinSigmaPx * kMinSigmaPx * num_corners;
  return std::max(2 * fit.summary.cost - drop, floor) / freedom;
}

// Sigmas and agreement of the views; nothing where these do not determine the bend.
std::optional<ShapeInformation> describeBend(const Fit& fit, ShapeReport& report) {
  auto info = shapeInformation(fit);
  report.is_determined = info.has_value();
  if (!info) return info;
  report.std_m = (varianceLeft(fit, info->drop) * info->bend_inverse.diagonal()).cwiseSqrt();
  report.by_views = byViews(fit, *info);
  return info;
}

// On the same corners.
Fit flattened(Fit fit, const std::vector<double>& params) {
  onlyBoard(fit) = {.target = onlyBoard(fit).target};
  onlyCamera(fit).params = params;
  return fit;
}

}  // namespace

std::optional<BendByViews> bendByViews(const ShapeInformation& information, const Eigen::Vector2d& bend_m,
                                       const Eigen::MatrixXd& directions, double mean_slope) {
  constexpr double kFewest = 2;  // degrees of freedom; below, not even a strong bend would be significant
  const auto shares =
      ViewShares::make(information.pulls, withBend(directions), mean_slope, information.prior);
  if (!shares) return std::nullopt;
  const Eigen::MatrixXd bend = shares->basis().bottomRows<kNumBends>();
  const Eigen::Vector2d freedoms(shares->freedomOf(bend.row(0).transpose()),
                                 shares->freedomOf(bend.row(1).transpose()));
  BendByViews result{.freedom = freedoms.minCoeff()};
  if (!(result.freedom > kFewest)) return std::nullopt;
  const Eigen::Matrix2d covariance = bend * shares->covariance() * bend.transpose();
  const double t2 = bend_m.dot(covariance.inverse() * bend_m);
  const double n = result.freedom;
  result.f = (n - 1) / (2 * n) * t2;
  result.chance = std::pow(1 + t2 / n, -0.5 * (n - 1));  // F with 2 degrees above has it in closed form
  for (int i = 0; i < kNumBends; ++i)
    result.std_m(i) = std::sqrt(covariance(i, i)) * studentT95(freedoms(i)) / kNormal95;
  return result;
}

bool isBent(double f, const std::optional<BendByViews>& by_views) {
  constexpr double kChance = 0.05;  // it comes on top of kBendF, which a flat board hardly ever exceeds
  return f > kBendF && !(by_views && by_views->chance > kChance);
}

bool isShapeEstimated(const Fit& fit) {
  return !onlyBoard(fit).is_shape_fixed;
}

BentFit bent(SettledFit flat, BoardShapeMode mode, const CancelFlag* cancel) {
  BentFit result{.settled = std::move(flat), .report = {}};
  if (mode == BoardShapeMode::kFlat) return result;
  ShapeReport& report = result.report;
  SettledFit& now = result.settled;
  report.is_requested = mode == BoardShapeMode::kWarp;
  const auto info = describeBend(now.fit, report);
  if (!info) return result;
  report.f = info->drop / kNumBends / varianceLeft(now.fit, info->drop);
  if (mode == BoardShapeMode::kAuto && !isBent(report.f, report.by_views)) return result;
  const auto larger = mode == BoardShapeMode::kAuto ? betterModel(now.fit, cancel) : std::nullopt;
  const Fit before = now.fit;
  FitBoard& board = onlyBoard(now.fit);
  board.is_shape_fixed = false;
  board.shape = {.bend_x_m = info->step_m.x(), .bend_y_m = info->step_m.y()};
  now.fit = solve(std::move(now.fit), {.cancel = cancel});
  // What looked like noise was the bend: weights and loss are settled anew.
  now = settledWeights(std::move(now.fit), cancel);
  const bool is_determined = describeBend(now.fit, report).has_value();
  // A bend takes up some of what a model lacks. If the larger model explains more than the bend, it is that.
  if (is_determined && !(larger && larger->rms_px < weightedRms(now.fit))) {
    report.flat_params = onlyCamera(before).params;
    return result;
  }
  now.fit = flattened(std::move(now.fit), onlyCamera(before).params);
  now.fit.placements = before.placements;
  now.fit = solve(std::move(now.fit), {.cancel = cancel});
  now = settledWeights(std::move(now.fit), cancel);
  return result;
}

BentFit bendTestedAgain(BentFit bent, BoardShapeMode mode, const CancelFlag* cancel) {
  constexpr double kFlatTolerance = 1e-9;  // of the cost: far below a difference that counts
  Fit& fit = bent.settled.fit;
  ShapeReport& report = bent.report;
  if (!isShapeEstimated(fit)) return bent;
  const bool is_determined = describeBend(fit, report).has_value();
  Fit flat =
      solve(flattened(fit, report.flat_params), {.function_tolerance = kFlatTolerance, .cancel = cancel});
  report.f = 2 * (flat.summary.cost - fit.summary.cost) / kNumBends / varianceLeft(fit, 0);
  report.flat_params = onlyCamera(flat).params;
  report.flat_rms_px = weightedRms(flat);
  if (is_determined && (mode == BoardShapeMode::kWarp || isBent(report.f, report.by_views))) return bent;
  // What looked like a bend was outliers.
  report.flat_params.clear();
  report.flat_rms_px = std::numeric_limits<double>::quiet_NaN();
  fit = solve(std::move(flat), {.cancel = cancel});
  return bent;
}

std::optional<IgnoredBend> ignoredBend(const Fit& fit) {
  const auto info = shapeInformation(fit);
  if (!info) return std::nullopt;
  const double f = info->drop / kNumBends / varianceLeft(fit, info->drop);
  if (!isBent(f, byViews(fit, *info))) return std::nullopt;
  return IgnoredBend{.shape = {.bend_x_m = info->step_m.x(), .bend_y_m = info->step_m.y()},
                     .params_step = info->params_step,
                     .cost_share = 1 - info->drop / (2 * fit.summary.cost)};
}

}  // namespace alidade
