// SPDX-License-Identifier: MIT
#include "alidade/detect/edge_solver.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace alidade {
namespace {

using Matrix = Eigen::Matrix<double, NormalEquations::kSize, NormalEquations::kSize>;
using Vector = Eigen::Matrix<double, NormalEquations::kSize, 1>;

// Adds the prior's terms; `sums` are those of the pixels alone.
void addPrior(const EdgePrior& prior, const EdgeModel& model, NormalEquations& sums) {
  for (int i = 0; i < NormalEquations::kSize; ++i) {
    const auto p = static_cast<std::size_t>(i);
    const double off = prior.expected[p] - model[p];
    sums.hessian(i, i) += prior.precision[p];
    sums.gradient(i) += prior.precision[p] * off;
    sums.cost += prior.precision[p] * off * off;
  }
  const double off = model[EdgeModel::kBlur2] - model[EdgeModel::kBlur1];
  constexpr int k1 = EdgeModel::kBlur1;
  constexpr int k2 = EdgeModel::kBlur2;
  if (prior.common_blur) {  // one unknown in the place of the first, and nothing to solve for the second
    sums.hessian.col(k1) += sums.hessian.col(k2);
    sums.hessian.row(k1) += sums.hessian.row(k2);
    sums.gradient(k1) += sums.gradient(k2);
    sums.hessian.col(k2).setZero();
    sums.hessian.row(k2).setZero();
    sums.hessian(k2, k2) = 1;
    sums.gradient(k2) = 0;
    return;
  }
  sums.hessian(k1, k1) += prior.equal_blur;
  sums.hessian(k2, k2) += prior.equal_blur;
  sums.hessian(k1, k2) -= prior.equal_blur;
  sums.hessian(k2, k1) -= prior.equal_blur;
  sums.gradient(k1) += prior.equal_blur * off;
  sums.gradient(k2) -= prior.equal_blur * off;
  sums.cost += prior.equal_blur * off * off;
}

// Takes a blur that is at its bound and wants beyond out of the step.
void holdAtBounds(const EdgeModel& model, const EdgeSolverOptions& options, NormalEquations& sums) {
  for (const auto p : {EdgeModel::kBlur1, EdgeModel::kBlur2}) {
    const int i = p;
    const bool is_held = (model[p] <= options.min_blur_px && sums.gradient(i) < 0) ||
                         (model[p] >= options.max_blur_px && sums.gradient(i) > 0);
    if (!is_held) continue;
    sums.hessian.col(i).setZero();
    sums.hessian.row(i).setZero();
    sums.hessian(i, i) = 1;
    sums.gradient(i) = 0;
  }
}

}  // namespace

EdgeSolution solveEdgeModel(const EdgePixels& pixels, const EdgeModel& start, const EdgePrior& prior,
                            const EdgeSolverOptions& options) {
  // Images are stored in whole grey levels: no residuals are smaller than their rounding.
  constexpr double kLeastVariance = 1.0 / 12;
  constexpr double kMaxDamping = 1e7;
  EdgeSolution solution{.model = start, .sums = {}, .converged = false, .num_evaluations = 1};
  sumNormalEquations(pixels, start, solution.sums);
  addPrior(prior, start, solution.sums);
  holdAtBounds(start, options, solution.sums);
  NormalEquations trial_sums;
  double damping = 1e-3;
  for (int iteration = 0; iteration < options.max_iterations; ++iteration) {
    const NormalEquations& sums = solution.sums;
    const Vector scale = sums.hessian.diagonal().cwiseMax(1e-12).cwiseSqrt().cwiseInverse();
    Matrix system = scale.asDiagonal() * sums.hessian * scale.asDiagonal();
    system.diagonal().array() += damping;
    const Vector step = scale.cwiseProduct(system.llt().solve(scale.cwiseProduct(sums.gradient)));
    if (!step.allFinite()) return solution;
    // Length of the step in standard deviations, by what Gauss-Newton expects to gain.
    const double variance = std::max(kLeastVariance, sums.cost / static_cast<double>(pixels.size()));
    const double gain = step.dot(sums.gradient);
    const bool is_last = damping < 0.1 && gain <= options.step_share * options.step_share * variance;
    EdgeModel trial = solution.model;
    for (int i = 0; i < NormalEquations::kSize; ++i) trial[static_cast<std::size_t>(i)] += step(i);
    if (prior.common_blur) trial[EdgeModel::kBlur2] = trial[EdgeModel::kBlur1];
    for (const auto blur : {EdgeModel::kBlur1, EdgeModel::kBlur2})
      trial[blur] = std::clamp(trial[blur], options.min_blur_px, options.max_blur_px);
    if (is_last) {  // too short to look at
      solution.model = trial;
      solution.converged = true;
      return solution;
    }
    sumNormalEquations(pixels, trial, trial_sums);
    addPrior(prior, trial, trial_sums);
    holdAtBounds(trial, options, trial_sums);
    ++solution.num_evaluations;
    if (trial_sums.cost < sums.cost) {
      damping = std::max(1e-7, 0.1 * damping);
      solution.model = trial;
      std::swap(solution.sums, trial_sums);
    } else {
      if (gain <= options.step_share * options.step_share * variance) {
        solution.converged = true;  // rounding decides which of the two is better
        return solution;
      }
      damping *= 10;
      if (damping > kMaxDamping) return solution;
    }
  }
  return solution;
}

}  // namespace alidade
