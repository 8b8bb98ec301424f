// SPDX-License-Identifier: MIT
#include "alidade/calibrate/bend/shape_fit.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include <Eigen/LU>

#include "alidade/adjust/board/errors.h"
#include "alidade/adjust/board/solve.h"
#include "alidade/adjust/noise/board_offsets.h"
#include "alidade/adjust/noise/covariance.h"
#include "alidade/adjust/noise/larger_model.h"
#include "alidade/adjust/noise/view_shares.h"
#include "alidade/core/statistics.h"

namespace alidade {
namespace {

// For the last board of `information`.
std::optional<BendByViews> byViews(const Fit& fit, const ShapeInformation& info) {
  const FitCamera& camera = onlyCamera(fit);
  const BoardShape& shape = fit.boards[info.boards.back()].shape;
  const Eigen::Vector2d step_m = info.step_m.tail<kNumBends>();
  return bendByViews(info, Eigen::Vector2d(shape.bend_x_m, shape.bend_y_m) + step_m,
                     freeDirections(static_cast<int>(camera.params.size()), camera.constraint),
                     meanSlope(weightedErrors(fit), fit.loss), info.boards.size() - 1);
}

// Variance of a coordinate after freeing the bends of this many boards: twice the remaining cost over the
// remaining degrees of freedom.
double varianceLeft(const Fit& fit, double drop, std::size_t num_bent) {
  const auto num_corners = static_cast<double>(numCorners(fit));
  const double freedom = 2.0 * num_corners - static_cast<double>(onlyCamera(fit).params.size()) -
                         6.0 * static_cast<double>(fit.views.size()) -
                         kNumBends * static_cast<double>(num_bent) - numFreeOffsets(fit);
  const double floor = 2 * kMinSigmaPx * kMinSigmaPx * num_corners;
  return std::max(2 * fit.summary.cost - drop, floor) / freedom;
}

double varianceLeft(const Fit& fit, const ShapeInformation& info) {
  return varianceLeft(fit, info.drop, info.boards.size());
}

// These boards, the given one last.
std::vector<std::size_t> endingWith(std::vector<std::size_t> boards, std::size_t board) {
  std::erase(boards, board);
  boards.push_back(board);
  return boards;
}

// Sigmas and agreement between views for a board, given the bends already estimated; nothing if the views do
// not determine it. The board is the last one of `information`.
std::optional<ShapeInformation> describeBend(const Fit& fit, std::size_t board, ShapeReport& report) {
  auto info = shapeInformation(fit, endingWith(estimatedShapes(fit), board));
  report.is_determined = info.has_value();
  if (!info) return info;
  const Eigen::VectorXd variances = varianceLeft(fit, *info) * info->bend_inverse.diagonal();
  report.std_m = variances.tail<kNumBends>().cwiseSqrt();
  report.by_views = byViews(fit, *info);
  return info;
}

// Refits the same corners with this board flat.
Fit flattened(Fit fit, std::size_t board, const std::vector<double>& params) {
  FitBoard& flat = fit.boards[board];
  flat.shape = {.offsets_m = std::move(flat.shape.offsets_m)};
  flat.is_shape_fixed = true;
  onlyCamera(fit).params = params;
  return fit;
}

// Describes the boards that are still to be tested, and returns the first estimate of the most significant
// bend, that of its last board; nothing if no board counts as bent.
std::optional<ShapeInformation> mostBent(const Fit& fit, const std::vector<bool>& is_open,
                                         BoardShapeMode mode, std::vector<ShapeReport>& reports) {
  std::optional<ShapeInformation> most;
  for (std::size_t b = 0; b < is_open.size(); ++b) {
    if (!is_open[b]) continue;
    ShapeReport& report = reports[b];
    auto info = describeBend(fit, b, report);
    if (!info) continue;
    report.f = info->drop / kNumBends / varianceLeft(fit, *info);
    if (mode != BoardShapeMode::kWarp && !isBent(report.f, report.by_views)) continue;
    if (!most || report.f > reports[most->boards.back()].f) most = std::move(info);
  }
  return most;
}

// Solves with a further bend, unless a larger lens model explains more.
void bend(SettledFit& now, const ShapeInformation& further, BoardShapeMode mode, const CancelFlag* cancel,
          ShapeReport& report) {
  const std::size_t at = further.boards.back();
  const auto larger = mode != BoardShapeMode::kWarp ? betterModel(now.fit, cancel) : std::nullopt;
  const Fit before = now.fit;
  FitBoard& board = now.fit.boards[at];
  const Eigen::Vector2d step_m = further.step_m.tail<kNumBends>();
  board.is_shape_fixed = false;
  board.shape.bend_x_m = step_m.x();
  board.shape.bend_y_m = step_m.y();
  now.fit = solve(std::move(now.fit), {.cancel = cancel});
  // Part of the apparent noise was the bend, so settle weights and loss again.
  now = settledWeights(std::move(now.fit), cancel);
  const bool is_determined = describeBend(now.fit, at, report).has_value();
  // A bend absorbs part of what the model lacks. If a larger model explains more, the model is at fault.
  if (is_determined && !(larger && larger->rms_px < weightedRms(now.fit))) {
    report.flat_params = onlyCamera(before).params;
    return;
  }
  now.fit.boards = before.boards;
  onlyCamera(now.fit).params = onlyCamera(before).params;
  now.fit.placements = before.placements;
  now.fit = solve(std::move(now.fit), {.cancel = cancel});
  now = settledWeights(std::move(now.fit), cancel);
}

// See testBendsAgain(). False if the board is taken as flat.
bool isStillBent(Fit& fit, std::size_t board, BoardShapeMode mode, const CancelFlag* cancel,
                 ShapeReport& report) {
  constexpr double kFlatTolerance = 1e-9;  // of the cost, far below any difference that matters
  const bool is_determined = describeBend(fit, board, report).has_value();
  Fit flat = solve(flattened(fit, board, report.flat_params),
                   {.function_tolerance = kFlatTolerance, .cancel = cancel});
  report.f = 2 * (flat.summary.cost - fit.summary.cost) / kNumBends /
             varianceLeft(fit, 0, estimatedShapes(fit).size());
  report.flat_params = onlyCamera(flat).params;
  report.flat_rms_px = weightedRms(flat);
  if (is_determined && (mode == BoardShapeMode::kWarp || isBent(report.f, report.by_views))) return true;
  // Outliers caused the apparent bend.
  report.flat_params.clear();
  report.flat_rms_px = std::numeric_limits<double>::quiet_NaN();
  fit = solve(std::move(flat), {.cancel = cancel});
  return false;
}

// Effect of one more bend in addition to others, in a fit in which all boards are flat.
std::optional<ShapeInformation> furtherBend(const Fit& fit, const std::vector<std::size_t>& others,
                                            double drop_by_others) {
  std::optional<ShapeInformation> most;
  double most_f = 0;
  for (std::size_t b = 0; b < fit.boards.size(); ++b) {
    if (std::ranges::find(others, b) != others.end()) continue;
    auto info = shapeInformation(fit, endingWith(others, b));
    if (!info) continue;
    const double f = (info->drop - drop_by_others) / kNumBends / varianceLeft(fit, *info);
    if (!isBent(f, byViews(fit, *info)) || (most && f <= most_f)) continue;
    most = std::move(info);
    most_f = f;
  }
  return most;
}

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

// The fit with offsets if the views confirm them.
std::optional<Fit> ifBorneOut(const Fit& even, Choice& choice, int jobs, const CancelFlag* cancel) {
  const Fit started = startedUneven(even, testableBoards(even));
  // An improvement of held-out errors also shows in the errors of the fit.
  constexpr double kMostLeft = (1 - kWorthwhile) * (1 - kWorthwhile);
  if (!isAnyUneven(started) || varianceLeftByOffsets(started, kMostLeft) > kMostLeft) return std::nullopt;
  auto fit = withOffsets(started, OffsetScatter::kEstimate, cancel);
  if (!fit || !isAnyUneven(*fit)) return std::nullopt;
  const auto larger = betterModel(even, cancel);
  if (larger && larger->rms_px < weightedRms(*fit)) return std::nullopt;
  const auto of_even = heldOutErrors(even, jobs, cancel);
  const auto of_uneven = heldOutErrors(*fit, jobs, cancel);
  if (!of_even || !of_uneven) return std::nullopt;
  choice.even_excess = excessOf(scoreOf(*of_even, even), scoreOf(*of_uneven, *fit));
  if (!choice.even_excess->is_significant || !(choice.even_excess->proven_share > kWorthwhile))
    return std::nullopt;
  return fit;
}

}  // namespace

std::optional<BendByViews> bendByViews(const ShapeInformation& information, const Eigen::Vector2d& bend_m,
                                       const Eigen::MatrixXd& directions, double mean_slope,
                                       std::size_t which) {
  constexpr double kFewest = 2;  // degrees of freedom; with fewer, not even a strong bend is significant
  const Eigen::Index num_params = directions.rows();
  const Eigen::Index num_bends = information.pulls.front().gradient.size() - num_params;
  const auto shares =
      ViewShares::make(information.pulls, withBends(directions, num_bends), mean_slope, information.prior);
  if (!shares) return std::nullopt;
  const Eigen::MatrixXd bend =
      shares->basis().middleRows<kNumBends>(num_params + kNumBends * static_cast<Eigen::Index>(which));
  const Eigen::Vector2d freedoms(shares->freedomOf(bend.row(0).transpose()),
                                 shares->freedomOf(bend.row(1).transpose()));
  BendByViews result{.freedom = freedoms.minCoeff()};
  if (!(result.freedom > kFewest)) return std::nullopt;
  const Eigen::Matrix2d covariance = bend * shares->covariance() * bend.transpose();
  const double t2 = bend_m.dot(covariance.inverse() * bend_m);
  const double n = result.freedom;
  result.f = (n - 1) / (2 * n) * t2;
  result.chance = std::pow(1 + t2 / n, -0.5 * (n - 1));  // tail of F(2, n - 1) in closed form
  for (int i = 0; i < kNumBends; ++i)
    result.std_m(i) = std::sqrt(covariance(i, i)) * studentT95(freedoms(i)) / kNormal95;
  return result;
}

bool isBent(double f, const std::optional<BendByViews>& by_views) {
  constexpr double kChance = 0.05;  // in addition to kBendF, which a flat board hardly ever exceeds
  return f > kBendF && !(by_views && by_views->chance > kChance);
}

std::vector<std::size_t> estimatedShapes(const Fit& fit) {
  std::vector<std::size_t> boards;
  for (std::size_t b = 0; b < fit.boards.size(); ++b) {
    if (!fit.boards[b].is_shape_fixed) boards.push_back(b);
  }
  return boards;
}

bool isShapeEstimated(const Fit& fit) {
  return !estimatedShapes(fit).empty();
}

std::vector<ShapeReport> estimateBends(SettledFit& now, BoardShapeMode mode, const CancelFlag* cancel) {
  std::vector<ShapeReport> reports(now.fit.boards.size());
  if (mode == BoardShapeMode::kFlat) return reports;
  for (ShapeReport& report : reports) report.is_requested = mode == BoardShapeMode::kWarp;
  std::vector<bool> is_open(reports.size(), true);
  while (const auto further = mostBent(now.fit, is_open, mode, reports)) {
    is_open[further->boards.back()] = false;
    bend(now, *further, mode, cancel, reports[further->boards.back()]);
  }
  return reports;
}

void testBendsAgain(SettledFit& now, std::vector<ShapeReport>& reports, BoardShapeMode mode,
                    const CancelFlag* cancel) {
  // Removing a false bend changes how the others look.
  const auto isStill = [&](std::size_t b) { return isStillBent(now.fit, b, mode, cancel, reports[b]); };
  while (!std::ranges::all_of(estimatedShapes(now.fit), isStill)) continue;
}

std::optional<IgnoredBend> ignoredBend(const Fit& fit) {
  std::optional<ShapeInformation> info = furtherBend(fit, {}, 0);
  if (!info) return std::nullopt;
  while (auto further = furtherBend(fit, info->boards, info->drop)) info = std::move(further);
  IgnoredBend ignored{.boards = info->boards,
                      .shapes = {},
                      .params_step = info->params_step,
                      .cost_share = 1 - info->drop / (2 * fit.summary.cost)};
  for (Eigen::Index i = 0; i < info->step_m.size(); i += kNumBends)
    ignored.shapes.push_back({.bend_x_m = info->step_m(i), .bend_y_m = info->step_m(i + 1)});
  return ignored;
}

void estimateOffsets(SettledFit& now, BoardShapeMode mode, int jobs, const CancelFlag* cancel,
                     Choice& choice) {
  std::optional<Fit> fit;
  if (mode == BoardShapeMode::kAuto) fit = ifBorneOut(now.fit, choice, jobs, cancel);
  if (mode == BoardShapeMode::kUneven) {
    std::vector<std::size_t> all(now.fit.boards.size());
    std::iota(all.begin(), all.end(), 0);
    fit = withOffsets(startedUneven(now.fit, all), OffsetScatter::kEstimate, cancel);
    choice.are_offsets_undetermined = !fit || !isAnyUneven(*fit);
  }
  if (!fit) return;
  // Part of the apparent noise was the board.
  now = settledWeights(*std::move(fit), cancel);
  estimateOffsetsAgain(now, cancel);
}

void estimateOffsetsAgain(SettledFit& now, const CancelFlag* cancel) {
  if (auto fit = withOffsets(now.fit, OffsetScatter::kEstimate, cancel)) {
    now.fit = *std::move(fit);
    return;
  }
  // Offsets that do not converge are discarded.
  for (FitBoard& board : now.fit.boards) makeEven(board);
  now.fit = solve(std::move(now.fit), {.cancel = cancel});
}

}  // namespace alidade
