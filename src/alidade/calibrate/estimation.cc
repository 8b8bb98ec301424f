// SPDX-License-Identifier: MIT
#include "alidade/calibrate/estimation.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "alidade/calibrate/held_params.h"
#include "alidade/calibrate/start.h"
#include "alidade/core/error.h"
#include "alidade/core/text.h"

namespace alidade {

Estimation::Estimation(const Checkerboard& board_in, std::vector<View> views_in,
                       const CalibratorOptions& options_in)
    : board(board_in),
      options(options_in),
      constraint(constraintOf(options_in)),
      views(std::move(views_in)) {}

void solve(Estimation& estimation, double function_tolerance) {
  estimation.summary = solveBundle(estimation.options.model, estimation.observations, estimation.state,
                                   {.loss = estimation.loss,
                                    .function_tolerance = function_tolerance,
                                    .constraint = estimation.constraint,
                                    .prior = estimation.weak_prior.prior,
                                    .cancel = estimation.options.cancel});
  estimation.errors.clear();
  for (std::size_t v = 0; v < estimation.views.size(); ++v) {
    estimation.errors.push_back(reprojectionErrors(estimation.options.model, estimation.state.params,
                                                   estimation.state.camera_from_board[v],
                                                   estimation.observations[v]));
  }
}

double weigh(const CornerNoise& noise, Observations& views) {
  double change = 0;
  for (auto& view : views) {
    for (Observation& observation : view) {
      const double weight = noise.weight(observation.sigma_px);
      change = std::max(change, std::abs(weight / observation.weight - 1));
      observation.weight = weight;
    }
  }
  return change;
}

std::vector<Eigen::Vector2d> weightedErrors(const Estimation& estimation) {
  std::vector<Eigen::Vector2d> errors;
  for (std::size_t v = 0; v < estimation.errors.size(); ++v) {
    for (std::size_t i = 0; i < estimation.errors[v].size(); ++i)
      errors.emplace_back(std::sqrt(estimation.observations[v][i].weight) * estimation.errors[v][i]);
  }
  return errors;
}

double meanWeightedSquare(const Estimation& estimation) {
  const std::vector<Eigen::Vector2d> errors = weightedErrors(estimation);
  double sum = 0;
  for (const Eigen::Vector2d& error : errors) sum += error.squaredNorm();
  return sum / static_cast<double>(errors.size());
}

double weightedRms(std::string_view model_id, const Observations& views, const BundleState& state) {
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const auto errors = reprojectionErrors(model_id, state.params, state.camera_from_board[v], views[v]);
    for (std::size_t i = 0; i < errors.size(); ++i) sum += views[v][i].weight * errors[i].squaredNorm();
    count += errors.size();
  }
  return std::sqrt(sum / static_cast<double>(count));
}

namespace {

void removeView(Estimation& estimation, std::size_t view) {
  const auto erase = [view](auto& list) {
    if (view < list.size()) list.erase(list.begin() + static_cast<std::ptrdiff_t>(view));
  };
  erase(estimation.views);
  erase(estimation.observations);
  erase(estimation.errors);
  erase(estimation.state.camera_from_board);
}

}  // namespace

void setAside(Estimation& estimation, std::size_t view) {
  const auto at =
      std::upper_bound(estimation.misfits.begin(), estimation.misfits.end(), estimation.views[view],
                       [](const View& a, const View& b) { return naturalLess(a.image, b.image); });
  estimation.misfits.insert(at, estimation.views[view]);
  removeView(estimation, view);
}

void exclude(Estimation& estimation, std::size_t view, std::string reason) {
  estimation.excluded.push_back({estimation.views[view].image, std::move(reason)});
  removeView(estimation, view);
}

void requireViews(const Estimation& estimation) {
  if (estimation.views.size() >= kMinViews) return;
  std::vector<std::string> reasons;
  for (const ExcludedView& view : estimation.excluded) reasons.push_back(view.image + ": " + view.reason);
  for (const RepeatedView& view : estimation.repeated)
    reasons.push_back(view.image + ": shows the board at the same place as " + view.same_as);
  for (const View& view : estimation.misfits)
    reasons.push_back(view.image + ": does not fit the other views");
  throw inputError(
      {.where = "calibration",
       .found = std::to_string(estimation.views.size()) + " usable views (" + join(reasons, "; ") + ")",
       .expected = "at least " + std::to_string(kMinViews),
       .next_step = "check the board's size and that all images are of the same camera"});
}

}  // namespace alidade
