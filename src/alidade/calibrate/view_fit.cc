// SPDX-License-Identifier: MIT
#include "alidade/calibrate/view_fit.h"

#include <algorithm>
#include <cmath>

#include "alidade/calibrate/local_sigma.h"
#include "alidade/calibrate/robust_weighting.h"
#include "alidade/calibrate/start.h"
#include "alidade/calibrate/view_preparation.h"
#include "alidade/core/median.h"
#include "alidade/init/pose_from_rays.h"

namespace alidade {
namespace {

std::vector<Observation> weightedObservations(const Estimation& e, const View& view) {
  Observations one = observationsOf(e.board, std::span(&view, 1));
  for (Observation& o : one.front()) o.p_board = onBentBoard(e.board, e.shape.shape, o.p_board);
  weigh(e.noise, one);
  return std::move(one.front());
}

}  // namespace

double noiseSigma(const Estimation& e) {
  return e.loss.threshold_px / kLossSigmas;
}

ViewFit fitInUse(const Estimation& e, std::size_t v) {
  ViewFit fit{.camera_from_board = e.state.camera_from_board[v],
              .observations = weightedObservations(e, e.views[v]),
              .errors = {}};
  fit.errors = reprojectionErrors(e.options.model, e.state.params, fit.camera_from_board, fit.observations);
  return fit;
}

std::optional<ViewFit> fitAlone(const Estimation& e, const View& view) {
  const AnyCamera camera = AnyCamera::make(e.options.model, e.state.params);
  const auto pose = poseFromView(camera, e.board, view.corners);
  if (!pose) return std::nullopt;
  ViewFit fit{.camera_from_board = *pose, .observations = weightedObservations(e, view), .errors = {}};
  const auto refined = refinedPose(e.options.model, e.state.params, *pose, fit.observations, e.loss);
  if (!refined) return std::nullopt;
  fit.camera_from_board = *refined;
  fit.errors = reprojectionErrors(e.options.model, e.state.params, *refined, fit.observations);
  return fit;
}

bool isOutlier(const Observation& observation, const Eigen::Vector2d& error, double sigma_px) {
  return !(std::sqrt(observation.weight) * error.norm() <= kOutlierSigmas * sigma_px);
}

std::size_t countOutliers(const ViewFit& fit, double sigma_px) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < fit.errors.size(); ++i) {
    if (isOutlier(fit.observations[i], fit.errors[i], sigma_px)) ++count;
  }
  return count;
}

double misfitRatio(const ViewFit& fit, double sigma_px) {
  double sum = 0;
  for (std::size_t i = 0; i < fit.errors.size(); ++i) {
    const bool is_outlier = isOutlier(fit.observations[i], fit.errors[i], sigma_px);
    sum += is_outlier ? kOutlierSigmas * kOutlierSigmas
                      : fit.observations[i].weight * fit.errors[i].squaredNorm() / (sigma_px * sigma_px);
  }
  return std::sqrt(0.5 * sum / static_cast<double>(fit.errors.size()));
}

bool isExplained(const ViewFit& fit, double sigma_px) {
  constexpr double kExplained = 2;
  return countOutliers(fit, sigma_px) == 0 && misfitRatio(fit, sigma_px) < kExplained;
}

bool isSmooth(const Checkerboard& board, const ViewFit& fit) {
  constexpr double kSmooth = 1.5;  // times what neighbours differ by
  double sum = 0;
  for (std::size_t i = 0; i < fit.errors.size(); ++i)
    sum += fit.observations[i].weight * fit.errors[i].squaredNorm();
  const double rms = std::sqrt(0.5 * sum / static_cast<double>(fit.errors.size()));
  return rms > kSmooth * localSigma(board, std::span(&fit.observations, 1), std::span(&fit.errors, 1));
}

double standOutRatio(std::vector<double> ratios) {
  constexpr double kTimes = 3;        // the typical ratio
  constexpr double kDeviations = 4;   // beyond it
  constexpr double kNormal = 1.4826;  // median absolute deviation to standard deviation
  const double typical = medianOf(ratios);
  for (double& ratio : ratios) ratio = std::abs(ratio - typical);
  return std::max(kTimes * std::max(1.0, typical), typical + kDeviations * kNormal * medianOf(ratios));
}

bool isForeign(const Checkerboard& board, const ViewFit& fit, double sigma_px, double stand_out_ratio) {
  constexpr std::size_t kMaxOutlierShare = 4;  // one in so many
  const std::size_t num_outliers = countOutliers(fit, sigma_px);
  if (fit.errors.size() - num_outliers < kMinCornersPerView) return true;
  if (misfitRatio(fit, sigma_px) < stand_out_ratio) return false;
  return kMaxOutlierShare * num_outliers > fit.errors.size() || isSmooth(board, fit);
}

}  // namespace alidade
