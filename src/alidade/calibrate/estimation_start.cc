// SPDX-License-Identifier: MIT
#include "alidade/calibrate/estimation_start.h"

#include <utility>

#include "alidade/calibrate/held_params.h"
#include "alidade/core/error.h"

namespace alidade {
namespace {

std::optional<Start> searchedOrGivenStart(const Estimation& e) {
  if (!e.options.initial) {
    return findStart(e.options.model, e.board, e.views, {.jobs = e.options.jobs, .cancel = e.options.cancel});
  }
  return startFrom(e.options.model, initialParameters(e.options, e.views.front().size), e.board, e.views);
}

void constrain(const Estimation& e, PosedCamera& camera) {
  const ImageSize size = e.views.front().size;
  if (!applyConstraint(e.options, e.constraint, size, camera.params)) return;
  improvePoses(e.options.model, e.board, e.views, startLoss(size), camera);
}

// The camera with its poses of the views that the start explains.
BundleState bundleState(const PosedCamera& camera, const std::vector<std::optional<SE3>>& start) {
  BundleState state{.params = camera.params, .camera_from_board = {}};
  for (std::size_t v = 0; v < start.size(); ++v) {
    if (start[v] && camera.poses[v]) state.camera_from_board.push_back(*camera.poses[v]);
  }
  return state;
}

struct Solved {
  std::vector<double> params;
  double cost = 0;
};

// May the corners that will be left out, or the board's shape, still bring the two within noise of each
// other?
bool isClose(const Estimation& e, double cost) {
  constexpr double kCloseChi2 = 100;  // about ten times what noise makes
  double num_coordinates = 0;
  for (const auto& view : e.observations) num_coordinates += 2 * static_cast<double>(view.size());
  return cost <= (1 + kCloseChi2 / num_coordinates) * e.summary.cost;
}

}  // namespace

void startEstimation(Estimation& e) {
  auto found = searchedOrGivenStart(e);
  if (!found) {
    throw inputError({.where = "calibration",
                      .found = "no " + e.options.model + " camera that explains these views even roughly",
                      .expected = "views of one flat board by one camera",
                      .next_step = "check the board's size; a wide-angle lens may need another model"});
  }
  constrain(e, found->camera);
  for (PosedCamera& rival : found->rivals) constrain(e, rival);
  e.start_report = found->report;
  const auto& poses = found->camera.poses;
  for (std::size_t v = e.views.size(); v-- > 0;) {
    if (!poses[v]) setAside(e, v);
  }
  e.state = bundleState(found->camera, poses);
  for (const PosedCamera& rival : found->rivals) e.rivals.push_back(bundleState(rival, poses));
  requireViews(e);
  e.observations = observationsOf(e.board, e.views);
}

void compareRivals(Estimation& e) {
  constexpr double kTolerance = 1e-9;  // of the cost
  std::vector<Solved> others;
  for (BundleState& rival : e.rivals) {
    if (rival.camera_from_board.size() < e.views.size()) continue;  // it explains fewer views
    const BundleSummary summary = solveBundle(e.options.model, e.observations, rival,
                                              {.loss = e.loss,
                                               .function_tolerance = kTolerance,
                                               .constraint = e.constraint,
                                               .cancel = e.options.cancel});
    if (summary.termination == Termination::kFailed) continue;
    if (!(summary.cost < (1 - kTolerance) * e.summary.cost)) {
      others.push_back({.params = std::move(rival.params), .cost = summary.cost});
      continue;
    }
    others.push_back({.params = std::move(e.state.params), .cost = e.summary.cost});
    e.state = std::move(rival);
    solve(e);
  }
  e.rivals.clear();
  for (Solved& other : others) {
    if (isClose(e, other.cost)) e.close_params.push_back(std::move(other.params));
  }
}

}  // namespace alidade
