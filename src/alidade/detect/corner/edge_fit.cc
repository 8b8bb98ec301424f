// SPDX-License-Identifier: MIT
#include "alidade/detect/corner/edge_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Cholesky>

#include "alidade/geometry/least_squares.h"

namespace alidade {
namespace {

// Removes a parameter from the normal equations.
void takeOut(int parameter, EdgeSums& sums) {
  sums.hessian.col(parameter).setZero();
  sums.hessian.row(parameter).setZero();
  sums.hessian(parameter, parameter) = 1;
  sums.gradient(parameter) = 0;
}

// Adds the prior's terms; `sums` are from the pixels alone.
void addPrior(const EdgePrior& prior, const EdgeModel& model, EdgeSums& sums) {
  for (int i = 0; i < sums.gradient.size(); ++i) {
    const auto p = static_cast<std::size_t>(i);
    const double off = 0 - model[p];
    sums.hessian(i, i) += prior.precision[p];
    sums.gradient(i) += prior.precision[p] * off;
    sums.cost += prior.precision[p] * off * off;
  }
  const double off = model[EdgeModel::kBlur2] - model[EdgeModel::kBlur1];
  constexpr int k1 = EdgeModel::kBlur1;
  constexpr int k2 = EdgeModel::kBlur2;
  if (prior.common_blur) {  // the first blur stands for both, and the second is removed
    sums.hessian.col(k1) += sums.hessian.col(k2);
    sums.hessian.row(k1) += sums.hessian.row(k2);
    sums.gradient(k1) += sums.gradient(k2);
    return takeOut(k2, sums);
  }
  sums.hessian(k1, k1) += prior.equal_blur;
  sums.hessian(k2, k2) += prior.equal_blur;
  sums.hessian(k1, k2) -= prior.equal_blur;
  sums.hessian(k2, k1) -= prior.equal_blur;
  sums.gradient(k1) += prior.equal_blur * off;
  sums.gradient(k2) -= prior.equal_blur * off;
  sums.cost += prior.equal_blur * off * off;
}

// Removes the angles from the step if they are held, and a blur if it is at its bound and would exceed it.
void hold(const EdgeModel& model, const EdgeSolverOptions& options, EdgeSums& sums) {
  if (options.are_angles_held) {
    takeOut(EdgeModel::kAngle1, sums);
    takeOut(EdgeModel::kAngle2, sums);
  }
  for (const auto p : {EdgeModel::kBlur1, EdgeModel::kBlur2}) {
    const int i = p;
    const bool is_held = (model[p] <= options.min_blur_px && sums.gradient(i) < 0) ||
                         (model[p] >= options.max_blur_px && sums.gradient(i) > 0);
    if (is_held) takeOut(i, sums);
  }
}

constexpr int kSectionsPerArm = 32;
constexpr int kNumSections = 2 * kSectionsPerArm;
constexpr int kNumShapes =
    4;  // offset of a line: position, angle, curvature, and opposite steps on the two arms

using LineSections = std::array<EdgeSection, kNumSections>;

// Noise variance from the scatter of the sections around the best smooth line. Each section is weighted by
// its information, as in the fit.
double scatterVariance(const LineSections& sections, double otherwise) {
  double most = 0;
  for (const EdgeSection& section : sections) most = std::max(most, section.information);
  Eigen::Matrix<double, kNumShapes, kNumShapes> normal =
      Eigen::Matrix<double, kNumShapes, kNumShapes>::Zero();
  Eigen::Matrix<double, kNumShapes, 1> right = Eigen::Matrix<double, kNumShapes, 1>::Zero();
  double square = 0;
  int count = 0;
  for (int i = 0; i < kNumSections; ++i) {
    const EdgeSection& section = sections[static_cast<std::size_t>(i)];
    if (!(section.information > 0.1 * most)) continue;
    const double u = (i + 0.5) / kSectionsPerArm - 1;
    const Eigen::Matrix<double, kNumShapes, 1> shape(1, u, u * u, u > 0 ? 1 : -1);
    normal.noalias() += section.information * shape * shape.transpose();
    right += section.score * shape;
    square += section.score * section.score / section.information;
    ++count;
  }
  const int freedom = count - kNumShapes;
  constexpr int kMinFreedom = 4;
  if (freedom < kMinFreedom) return otherwise;
  normal.diagonal().array() *= 1 + 1e-9;
  const double explained = right.dot(normal.ldlt().solve(right));
  return std::max(0.0, square - explained) / freedom;
}

}  // namespace

double EdgeContrast::share(double amplitude, double least_count, double least_variance) const {
  const double spread = pattern2 - pattern * pattern / std::max(1.0, count);
  if (count < least_count || !(spread > least_variance * count))
    return std::numeric_limits<double>::quiet_NaN();
  return 1 + (product - pattern * residual / count) / (spread * amplitude);
}

EdgeSolution solveEdgeModel(const EdgePixels& pixels, const EdgeModel& start, const EdgePrior& prior,
                            const EdgeSolverOptions& options) {
  EdgeSolution solution{.model = start, .sums = {}, .converged = false};
  const auto clampBlurs = [&](EdgeModel& model) {
    for (const auto blur : {EdgeModel::kBlur1, EdgeModel::kBlur2})
      model[blur] = std::clamp(model[blur], options.min_blur_px, options.max_blur_px);
  };
  clampBlurs(solution.model);
  const auto sumUp = [&](const EdgeModel& model, EdgeSums& sums) {
    sumNormalEquations(pixels, model, sums);
    addPrior(prior, model, sums);
    hold(model, options, sums);
  };
  sumUp(solution.model, solution.sums);
  EdgeSums trial_sums;
  const DampingRule rule{
      .start = 1e-3,
      .raised = [](double damping) { return 10 * damping > 1e7 ? HUGE_VAL : 10 * damping; },
      .lowered = [](double damping) { return std::max(1e-7, 0.1 * damping); },
      .max_steps = options.max_iterations};
  solution.converged = minimise(rule, [&](double damping) {
    const EdgeSums& sums = solution.sums;
    const EdgeSums::Vector step = sums.step(damping);
    if (!step.allFinite()) return StepResult::kFailed;
    const bool is_short = sums.isShort(step, options.step_share, pixels.size());
    EdgeModel trial = solution.model;
    for (int i = 0; i < step.size(); ++i) trial[static_cast<std::size_t>(i)] += step(i);
    if (prior.common_blur) trial[EdgeModel::kBlur2] = trial[EdgeModel::kBlur1];
    clampBlurs(trial);
    if (damping < 0.1 && is_short) {  // too short to evaluate
      solution.model = trial;
      return StepResult::kConverged;
    }
    sumUp(trial, trial_sums);
    if (!(trial_sums.cost < sums.cost))
      return is_short ? StepResult::kConverged : StepResult::kWorse;  // the difference is rounding
    solution.model = trial;
    std::swap(solution.sums, trial_sums);
    return StepResult::kBetter;
  });
  return solution;
}

EdgeQuality assessEdgeFit(const EdgePixels& pixels, const EdgeModel& model, const EdgeResiduals& residuals,
                          const std::array<double, 2>& reach_px) {
  // About ten sections per arm are enough for a variance; longer ones average residuals that are correlated
  // over a few pixels, as in the 8-pixel blocks of JPEG.
  constexpr double kSectionsWanted = 10;
  constexpr double kMinSectionPx = 1;
  constexpr double kMaxSectionPx = 8;
  // Pixels near the corner, where both lines blur into each other, belong to sections of neither line, and
  // even closer ones to no arm.
  constexpr double kSectionBlurs = 2.5;
  constexpr double kArmBlurs = 1.0;
  constexpr double kMinArmPixels = 6;
  constexpr double kMinArmVariance = 0.1;
  std::array<LineSections, 2> sections{};
  std::array<EdgeContrast, 4> arms{};
  const Eigen::Vector2d corner = model.corner();
  const std::array<Eigen::Vector2d, 2> directions = {model.direction(0), model.direction(1)};
  const std::array<Eigen::Vector2d, 2> normals = {model.normal(0), model.normal(1)};
  std::array<double, 2> per_px;
  std::array<double, 2> per_blur;
  for (std::size_t i = 0; i < 2; ++i) {
    const double length = std::clamp(reach_px[i] / kSectionsWanted, kMinSectionPx, kMaxSectionPx);
    per_px[i] = 1 / std::max(length, reach_px[i] / kSectionsPerArm);
    per_blur[i] = 1 / model[EdgeModel::kBlur1 + i];
  }
  std::array<double, 2> squares{};  // inner, outer
  std::array<double, 2> counts{};
  for (std::size_t p = 0; p < pixels.size(); ++p) {
    const double dx = pixels.x()[p] - corner.x();
    const double dy = pixels.y()[p] - corner.y();
    const double residual = residuals.residual[p];
    const double z0 = std::abs(dx * normals[0].x() + dy * normals[0].y()) * per_blur[0];
    const double z1 = std::abs(dx * normals[1].x() + dy * normals[1].y()) * per_blur[1];
    const std::size_t i = z0 < z1 ? 0 : 1;
    const double u = dx * directions[i].x() + dy * directions[i].y();
    const std::size_t half = 2 * std::abs(u) < reach_px[i] ? 0 : 1;
    squares[half] += residual * residual;
    counts[half] += 1;
    const double clear = std::max(z0, z1);
    if (clear < kArmBlurs) continue;
    if (clear >= kSectionBlurs) {
      const double slope = i == 0 ? residuals.slope1[p] : residuals.slope2[p];
      const int section =
          std::clamp(static_cast<int>(std::floor(u * per_px[i])) + kSectionsPerArm, 0, kNumSections - 1);
      sections[i][static_cast<std::size_t>(section)].add(slope, residual);
    }
    arms[2 * i + (u > 0 ? 0 : 1)].add(residuals.pattern[p], residual);
  }
  EdgeQuality quality;
  const double freedom = static_cast<double>(pixels.size()) - static_cast<double>(EdgeModel::kNumParameters);
  quality.residual_variance = (squares[0] + squares[1]) / std::max(1.0, freedom);
  quality.inner_variance = squares[0] / std::max(1.0, counts[0]);
  quality.outer_variance = squares[1] / std::max(1.0, counts[1]);
  const double amplitude = model[EdgeModel::kAmplitude] * model.shadeAtCorner();
  for (std::size_t i = 0; i < 2; ++i)
    quality.line_variance[i] = scatterVariance(sections[i], quality.residual_variance);
  for (std::size_t i = 0; i < 4; ++i)
    quality.arm_contrast[i] = arms[i].share(amplitude, kMinArmPixels, kMinArmVariance);
  return quality;
}

}  // namespace alidade
