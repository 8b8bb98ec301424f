// SPDX-License-Identifier: MIT
#include "alidade/calibrate/start/start_solver.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "alidade/adjust/errors.h"
#include "alidade/adjust/pose_from_rays.h"
#include "alidade/adjust/solve.h"

namespace alidade {
namespace {

constexpr int kMaxIterations = 100;
constexpr double kFine = 1e-6;  // relative change of the cost: tells optima apart; the full solve goes on

}  // namespace

StartSolver::StartSolver(const Checkerboard& board, ImageSize size,
                         std::vector<std::vector<Observation>> views, const CancelFlag* cancel)
    : board_(board), size_(size), views_(std::move(views)), loss_(startLoss(size)), cancel_(cancel) {}

void StartSolver::findPoses(std::string_view model_id, StartCandidate& candidate) const {
  const AnyCamera camera = AnyCamera::make(model_id, candidate.params);
  candidate.poses.assign(views_.size(), std::nullopt);
  candidate.cost = 0;
  std::size_t num_posed = 0;
  for (std::size_t v = 0; v < views_.size(); ++v) {
    const auto pose = poseFromCorners(camera, views_[v]);
    const double cost = pose ? viewCost(model_id, candidate.params, *pose, views_[v], loss_)
                             : std::numeric_limits<double>::quiet_NaN();
    if (std::isfinite(cost)) {
      candidate.poses[v] = pose;
      candidate.cost += cost;
      ++num_posed;
    } else {
      candidate.cost += missingViewCost(views_[v].size());
    }
  }
  if (num_posed < std::min(kMinPosedViews, views_.size()))
    candidate.cost = std::numeric_limits<double>::infinity();
}

// A start at which a view has no pose pays for it as if all its corners were far off: a bad start must not
// win by losing views, and one bad view must not rule out every start.
double StartSolver::missingViewCost(std::size_t num_corners) const {
  constexpr double kFarOff = 10;  // thresholds of the loss
  const double error = kFarOff * loss_.threshold_px;
  return 0.5 * static_cast<double>(num_corners) * loss_.rho(error * error);
}

bool StartSolver::solveLeanly(std::string_view model_id, StartCandidate& candidate) const {
  std::vector<int> held = {2, 3};
  for (int i = 5; i < static_cast<int>(candidate.params.size()); ++i) held.push_back(i);
  if (!solve(model_id, candidate, kCoarseTolerance, std::move(held))) return false;
  improvePoses(model_id, views_, loss_, candidate);
  return true;
}

bool StartSolver::solve(std::string_view model_id, StartCandidate& candidate) const {
  constexpr int kMaxRounds = 3;
  for (int round = 0; round < kMaxRounds; ++round) {
    if (!solve(model_id, candidate, kFine, {})) return false;
    if (!improvePoses(model_id, views_, loss_, candidate)) break;
  }
  return true;
}

bool StartSolver::solve(std::string_view model_id, StartCandidate& candidate, double tolerance,
                        std::vector<int> held, const LensPrior& prior) const {
  Fit fit = emptyFit(std::string(model_id), size_, candidate.params, board_, loss_);
  onlyCamera(fit).constraint.held = std::move(held);
  onlyCamera(fit).weak_prior.prior = prior;
  double missing_cost = 0;
  for (std::size_t v = 0; v < views_.size(); ++v) {
    if (candidate.poses[v] &&
        std::isfinite(viewCost(model_id, candidate.params, *candidate.poses[v], views_[v], loss_))) {
      addView(fit, v, views_[v], *candidate.poses[v]);
    } else {
      candidate.poses[v].reset();
      missing_cost += missingViewCost(views_[v].size());
    }
  }
  if (fit.views.size() < kMinPosedViews) return false;
  fit = alidade::solve(
      std::move(fit), {.max_iterations = kMaxIterations, .function_tolerance = tolerance, .cancel = cancel_});
  // An iteration limit is no failure here: the full solve goes on from where this one stopped.
  if (fit.summary.termination == Termination::kFailed) return false;
  candidate.params = onlyCamera(fit).params;
  candidate.cost = missing_cost + fit.summary.cost;
  for (const FitView& view : fit.views) candidate.poses[view.source] = cameraFromBoard(fit, view);
  return true;
}

LensPrior StartSolver::naturalPrior(std::string_view model_id, const AnyCamera& like,
                                    const StartCandidate& candidate) const {
  std::size_t num_corners = 0;
  for (std::size_t v = 0; v < views_.size(); ++v)
    if (candidate.poses[v]) num_corners += views_[v].size();
  const double variance = candidate.cost / static_cast<double>(std::max<std::size_t>(1, num_corners));
  return lensScale(model_id, like, size()).prior(1, variance);
}

bool StartSolver::isSameOptimum(std::string_view model_id, const StartCandidate& a,
                                const StartCandidate& b) const {
  constexpr double kSameCost = 1e-4;
  constexpr double kSameErrors = 0.05;  // root mean square of the difference as a share of the errors
  if (std::abs(a.cost - b.cost) > kSameCost * std::min(a.cost, b.cost)) return false;
  double sum = 0;
  double sum_difference = 0;
  for (std::size_t v = 0; v < views_.size(); ++v) {
    if (a.poses[v].has_value() != b.poses[v].has_value()) return false;
    if (!a.poses[v]) continue;
    const auto errors_a = reprojectionErrors(model_id, a.params, *a.poses[v], views_[v]);
    const auto errors_b = reprojectionErrors(model_id, b.params, *b.poses[v], views_[v]);
    for (std::size_t i = 0; i < errors_a.size(); ++i) {
      sum += errors_a[i].squaredNorm();
      sum_difference += (errors_a[i] - errors_b[i]).squaredNorm();
    }
  }
  return sum_difference <= kSameErrors * kSameErrors * sum;
}

}  // namespace alidade
