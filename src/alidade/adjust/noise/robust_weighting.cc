// SPDX-License-Identifier: MIT
#include "alidade/adjust/noise/robust_weighting.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "alidade/adjust/board/errors.h"
#include "alidade/adjust/board/pose_search.h"
#include "alidade/adjust/board/solve.h"
#include "alidade/adjust/board/view_kernel.h"
#include "alidade/adjust/noise/covariance.h"
#include "alidade/core/mapped.h"
#include "alidade/core/median.h"
#include "alidade/geometry/decompositions.h"

namespace alidade {
namespace {

// Joint covariance of a view's pose and the parameters, for corners of variance 1. The factor's rows give the
// change of the pose with the parameters, and the remaining uncertainty of the pose.
Eigen::MatrixXd jointCovariance(const ViewFactor& factor, const Eigen::MatrixXd& params_cov) {
  const Eigen::Index n = params_cov.rows();
  const Matrix6d root = inverseOfAny6(factor.topLeftCorner<6, 6>());
  const Eigen::MatrixXd pose_from_params = -root * factor.block(0, 6, 6, n);
  Eigen::MatrixXd joint(6 + n, 6 + n);
  joint.bottomRightCorner(n, n) = params_cov;
  joint.topRightCorner(6, n) = pose_from_params * params_cov;
  joint.bottomLeftCorner(n, 6) = joint.topRightCorner(6, n).transpose();
  joint.topLeftCorner<6, 6>() =
      root * root.transpose() + joint.topRightCorner(6, n) * pose_from_params.transpose();
  return joint;
}

// Weights that have not converged by then are kept, because any weights give an unbiased estimate.
constexpr int kMaxWeightRounds = 6;
constexpr double kLoose = 1e-6;  // of the cost: enough to estimate the noise from the errors

Fit solvedLoosely(Fit fit, const CancelFlag* cancel) {
  return solve(std::move(fit), {.function_tolerance = kLoose, .cancel = cancel});
}

// Updates the weights from the errors of the present fit; returns the largest relative change.
double reweigh(Fit& fit) {
  CornerNoise& noise = onlyCamera(fit).noise;
  if (noise.isUniform()) return 0;
  const auto all = leverages(fit);
  std::vector<CornerResidual> residuals;
  for (std::size_t v = 0; v < fit.views.size(); ++v) {
    const FitView& view = fit.views[v];
    for (std::size_t i = 0; i < view.corners.size(); ++i)
      residuals.push_back({view.corners[i].sigma_px, view.errors[i], all[v][i]});
  }
  noise.estimateUnexplained(residuals);
  return updateWeights(fit);
}

// The standard deviation of a coordinate of a corner of weight 1 from the median error, which outliers
// hardly move. The error of a clean corner follows Rayleigh's distribution, whose median is
// sqrt(2 ln 2) sigma.
double robustSigma(const Fit& fit) {
  const auto lengths = mapped(weightedErrors(fit), [](const Eigen::Vector2d& error) { return error.norm(); });
  return std::max(kMinSigmaPx, medianOf(lengths) / std::sqrt(2 * std::log(2.0)));
}

}  // namespace

std::vector<std::vector<double>> leverages(const Fit& fit) {
  const FitCamera& camera = onlyCamera(fit);
  const ViewKernel& kernel = viewKernel(camera.model, camera.params.size());
  const Eigen::Index n = kernel.numParams();
  // Undetermined intrinsics have little influence on the errors, so zero covariance is used.
  const Eigen::MatrixXd params_cov = intrinsicsInformation(fit).inverse.value_or(Eigen::MatrixXd::Zero(n, n));
  std::vector<std::vector<double>> all;
  ViewFactor rows;
  for (const FitView& view : fit.views) {
    const SE3 pose = cameraFromBoard(fit, view);
    const auto corners = groupsOf(cornersOnShape(fit, view));
    const auto factor = viewFactor(kernel, camera.params, pose, corners, kNoLoss, Unseen::kLeaveOut);
    const Eigen::MatrixXd covariance = jointCovariance(*factor, params_cov);
    rows.resize(2 * static_cast<Eigen::Index>(view.corners.size()), n + 7);
    kernel.rows(camera.params.data(), pose, corners, {rows.data(), static_cast<std::size_t>(rows.size())});
    const Eigen::VectorXd forms =
        (rows.leftCols(n + 6) * covariance).cwiseProduct(rows.leftCols(n + 6)).rowwise().sum();
    std::vector<double>& of_view = all.emplace_back();
    for (Eigen::Index i = 0; i < forms.size(); i += 2) of_view.push_back(forms(i) + forms(i + 1));
  }
  return all;
}

double noiseSigma(const Fit& fit) {
  return fit.loss.threshold_px / kLossSigmas;
}

SettledFit settled(Fit fit, const CancelFlag* cancel) {
  fit = solvedLoosely(std::move(fit), cancel);
  // A view may have got its pose from a camera that was still poor.
  if (improvePoses(fit)) fit = solvedLoosely(std::move(fit), cancel);
  return settledWeights(std::move(fit), cancel);
}

SettledFit settledWeights(Fit fit, const CancelFlag* cancel) {
  // A change of the threshold or of a weight by 2 % has no visible effect on parameters.
  constexpr double kSteady = 0.02;
  bool is_settled = false;
  for (int round = 0; round < kMaxRounds; ++round) {
    const double weight_change = round < kMaxWeightRounds ? reweigh(fit) : 0.0;
    const double threshold = kLossSigmas * robustSigma(fit);
    is_settled = weight_change < kSteady && std::abs(threshold / fit.loss.threshold_px - 1) < kSteady;
    if (is_settled) break;
    fit.loss.threshold_px = threshold;
    fit = solvedLoosely(std::move(fit), cancel);
  }
  return {.fit = solve(std::move(fit), {.cancel = cancel}), .is_settled = is_settled};
}

SettledFit settledFromStart(Fit fit, const CancelFlag* cancel) {
  fit.loss = startLoss(onlyCamera(fit).size);
  std::vector<double> sigmas;
  for (const FitView& view : fit.views) {
    for (const Observation& corner : view.corners) sigmas.push_back(corner.sigma_px);
  }
  onlyCamera(fit).noise = CornerNoise(sigmas);
  return settled(std::move(fit), cancel);
}

}  // namespace alidade
