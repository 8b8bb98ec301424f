// SPDX-License-Identifier: MIT
#include "alidade/calibrate/choose/model_solution.h"

#include <algorithm>
#include <array>
#include <optional>
#include <ranges>
#include <span>
#include <utility>

#include "alidade/adjust/board/solve.h"
#include "alidade/adjust/noise/robust_weighting.h"
#include "alidade/adjust/noise/weak_prior.h"
#include "alidade/calibrate/bend/flex_fit.h"
#include "alidade/calibrate/bend/shape_fit.h"
#include "alidade/calibrate/clean/outliers.h"
#include "alidade/calibrate/start/held_params.h"
#include "alidade/calibrate/start/start.h"
#include "alidade/core/error.h"

namespace alidade {
namespace {

// The fit with the camera and the poses of another solution; nothing if it explains fewer views.
std::optional<Fit> movedTo(const PosedCamera& other, Fit fit) {
  setLens(onlyCamera(fit).model, other.params, onlyCamera(fit));
  for (const FitView& view : fit.views) {
    const auto& pose = other.poses[view.source];
    if (!pose) return std::nullopt;
    setCameraFromBoard(fit, view, *pose);
  }
  return fit;
}

// True if leaving out corners, or the board's shape, may still bring the two within noise of each other.
bool isClose(const Fit& fit, double cost) {
  constexpr double kCloseChi2 = 100;  // about ten times the effect of noise
  const double num_coordinates = 2 * static_cast<double>(numCorners(fit));
  return cost <= (1 + kCloseChi2 / num_coordinates) * fit.summary.cost;
}

// Compares other optima that were about as good on the views of the start; on all views the lowest cost
// decides.
void compareWithRivals(std::span<const PosedCamera> rivals, const CancelFlag* cancel,
                       ModelSolution& solution) {
  constexpr double kTolerance = 1e-9;  // share of the cost
  Fit& fit = solution.fit;
  std::vector<Fit> others;
  for (const PosedCamera& camera : rivals) {
    auto rival = movedTo(camera, fit);
    if (!rival) continue;
    *rival = solve(*std::move(rival), {.function_tolerance = kTolerance, .cancel = cancel});
    if (rival->summary.termination == Termination::kFailed) continue;
    const bool is_better = rival->summary.cost < (1 - kTolerance) * fit.summary.cost;
    if (is_better) std::swap(fit, *rival);
    others.push_back(*std::move(rival));
    if (is_better) fit = solve(std::move(fit), {.cancel = cancel});
  }
  for (const Fit& other : others) {
    if (isClose(fit, other.summary.cost)) solution.close_params.push_back(onlyCamera(other).params);
  }
}

}  // namespace

ModelSolution fittedPlainly(const PreparedViews& given, const CalibratorOptions& options) {
  std::vector<std::vector<Observation>> corners = cornersOf(given);
  const ImageSize size = given.views.front().size;
  auto start = findStart(corners, size, options);
  if (!start) {
    throw inputError({.where = "calibration",
                      .found = "no " + options.model + " camera that explains these views even roughly",
                      .expected = "views of one flat board by one camera",
                      .next_step = "check the board's size; a wide-angle lens may need another model"});
  }
  const HuberLoss loss = startLoss(size);
  const ParamConstraint constraint = constraintOf(options);
  for (PosedCamera& camera : start->optima) {
    if (applyConstraint(options, constraint, size, camera.params))
      improvePoses(options.model, corners, loss, camera);
  }
  const PosedCamera& best = start->optima.front();
  Fit fit = emptyFit(options.model, size, best.params, given.boards, loss);
  onlyCamera(fit).constraint = constraint;
  for (std::size_t v = 0; v < corners.size(); ++v) {
    if (!best.poses[v]) continue;
    addView(fit, v, std::move(corners[v]), *best.poses[v], given.views[v].board);
    fit.views.back().image = given.views[v].image;
  }
  requireViews(given, fit);
  SettledFit settled = settledFromStart(std::move(fit), options.cancel);
  if (const std::size_t num_pupil = options.num_pupil.value_or(0); num_pupil > 0) {
    FitCamera& camera = onlyCamera(settled.fit);
    std::vector<double> pupil(num_pupil);
    if (options.initial) {
      const EntrancePupil& initial = options.initial->camera.pupil();
      std::ranges::copy(std::array{initial.s1_m, initial.s2_m} | std::views::take(num_pupil), pupil.begin());
    }
    camera.params.insert(camera.params.end(), pupil.begin(), pupil.end());
    settled = settledWeights(solve(std::move(settled.fit), {.cancel = options.cancel}), options.cancel);
  }
  ModelSolution solution{.fit = std::move(settled.fit),
                         .choice = {.start = start->report, .shapes = {}, .is_settled = settled.is_settled},
                         .close_params = {}};
  compareWithRivals(std::span(start->optima).subspan(1), options.cancel, solution);
  return solution;
}

ModelSolution withDataSettled(ModelSolution solution, const PreparedViews& given,
                              const CalibratorOptions& options) {
  const CancelFlag* cancel = options.cancel;
  solution.holdout.reset();
  SettledFit now{.fit = regularised(std::move(solution.fit), cancel),
                 .is_settled = solution.choice.is_settled};
  solution.choice.shapes = estimateBends(now, options.board_shape, cancel);
  estimateFlex(now, options.board_shape, cancel);
  if (!isAnyFlexible(now.fit))
    estimateOffsets(now, options.board_shape, options.jobs, cancel, solution.choice);
  now = withoutOutliers(std::move(now), given, cancel);
  const std::vector<std::size_t> bent_boards = estimatedShapes(now.fit);
  testBendsAgain(now, solution.choice.shapes, options.board_shape, cancel);
  if (estimatedShapes(now.fit) != bent_boards) now = withoutOutliers(std::move(now), given, cancel);
  // Again on the corners that are left.
  estimateOffsetsAgain(now, cancel);
  estimateFlexAgain(now, options.board_shape, cancel);
  solution.fit = regularised(std::move(now.fit), cancel);
  solution.choice.is_settled = now.is_settled;
  return solution;
}

ModelSolution withDataResettled(ModelSolution solution, const CalibratorOptions& options) {
  SettledFit now{.fit = std::move(solution.fit), .is_settled = solution.choice.is_settled};
  estimateOffsetsAgain(now, options.cancel);
  estimateFlexAgain(now, options.board_shape, options.cancel);
  solution.fit = regularised(std::move(now.fit), options.cancel);
  return solution;
}

}  // namespace alidade
