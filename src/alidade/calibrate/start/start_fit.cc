// SPDX-License-Identifier: MIT
#include "alidade/calibrate/start/start_fit.h"

#include <span>
#include <utility>

#include "alidade/adjust/board/solve.h"
#include "alidade/calibrate/start/held_params.h"
#include "alidade/core/error.h"

namespace alidade {
namespace {

std::optional<Start> searchedOrGivenStart(std::span<const std::vector<Observation>> corners, ImageSize size,
                                          const CalibratorOptions& options) {
  if (!options.initial)
    return findStart(options.model, corners, size, {.jobs = options.jobs, .cancel = options.cancel});
  return startFrom(options.model, initialParameters(options, size), corners, size);
}

// The fit with the camera and the poses of another solution; nothing if it explains fewer views.
std::optional<Fit> movedTo(const PosedCamera& other, Fit fit) {
  onlyCamera(fit).params = other.params;
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

}  // namespace

StartedFit startedFit(const PreparedViews& given, const CalibratorOptions& options) {
  std::vector<std::vector<Observation>> corners = cornersOf(given);
  const ImageSize size = given.views.front().size;
  auto start = searchedOrGivenStart(corners, size, options);
  if (!start) {
    throw inputError({.where = "calibration",
                      .found = "no " + options.model + " camera that explains these views even roughly",
                      .expected = "views of one flat board by one camera",
                      .next_step = "check the board's size; a wide-angle lens may need another model"});
  }
  const HuberLoss loss = startLoss(size);
  const ParamConstraint constraint = constraintOf(options);
  const auto constrain = [&](PosedCamera& camera) {
    if (applyConstraint(options, constraint, size, camera.params))
      improvePoses(options.model, corners, loss, camera);
  };
  constrain(start->camera);
  for (PosedCamera& rival : start->rivals) constrain(rival);
  StartedFit started{.fit = emptyFit(options.model, size, start->camera.params, given.boards, loss),
                     .rivals = std::move(start->rivals),
                     .report = start->report};
  onlyCamera(started.fit).constraint = constraint;
  for (std::size_t v = 0; v < corners.size(); ++v) {
    const auto& pose = start->camera.poses[v];
    if (!pose) continue;
    addView(started.fit, v, std::move(corners[v]), *pose, given.views[v].board);
    started.fit.views.back().image = given.views[v].image;
  }
  requireViews(given, started.fit);
  return started;
}

ComparedFit comparedWithRivals(Fit fit, const std::vector<PosedCamera>& rivals, const CancelFlag* cancel) {
  constexpr double kTolerance = 1e-9;  // of the cost
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
  ComparedFit compared{.fit = std::move(fit), .close_params = {}};
  for (const Fit& other : others) {
    if (isClose(compared.fit, other.summary.cost)) compared.close_params.push_back(onlyCamera(other).params);
  }
  return compared;
}

}  // namespace alidade
