// SPDX-License-Identifier: MIT
#include "alidade/calibrate/clean/view_fit.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "alidade/adjust/board/corner_noise.h"
#include "alidade/adjust/board/errors.h"
#include "alidade/adjust/board/view_pose.h"
#include "alidade/adjust/noise/robust_weighting.h"
#include "alidade/calibrate/start/prepared_views.h"
#include "alidade/core/median.h"

namespace alidade {
namespace {

std::vector<Observation> weightedCorners(const Fit& fit, const View& view) {
  std::vector<Observation> corners = observationsOf(fit.boards[view.board].target, view);
  for (Observation& corner : corners) corner.weight = onlyCamera(fit).noise.weight(corner.sigma_px);
  return corners;
}

ViewFit viewFit(const Fit& fit, std::size_t board_index, const SE3& camera_from_board,
                std::vector<Observation> corners) {
  const FitCamera& camera = onlyCamera(fit);
  const FitBoard& board = fit.boards[board_index];
  ViewFit of{.board = board_index,
             .camera_from_board = camera_from_board,
             .corners = std::move(corners),
             .errors = {}};
  of.errors = reprojectionErrors(camera.model, camera.params, camera_from_board,
                                 onShape(board.target, board.shape, of.corners));
  return of;
}

}  // namespace

ViewFit fitInUse(const Fit& fit, std::size_t v, const View& view) {
  return viewFit(fit, view.board, cameraFromBoard(fit, fit.views[v]), weightedCorners(fit, view));
}

std::optional<ViewFit> fitAlone(const Fit& fit, const View& view) {
  const FitCamera& camera = onlyCamera(fit);
  const FitBoard& board = fit.boards[view.board];
  std::vector<Observation> corners = weightedCorners(fit, view);
  const auto pose = poseFromCorners(AnyCamera::make(camera.model, camera.params), corners);
  if (!pose) return std::nullopt;
  const auto refined =
      refitPose(camera.model, camera.params, onShape(board.target, board.shape, corners), fit.loss, *pose);
  if (!refined) return std::nullopt;
  return viewFit(fit, view.board, *refined, std::move(corners));
}

bool isOutlier(const Observation& corner, const Eigen::Vector2d& error, double sigma_px) {
  return !(std::sqrt(corner.weight) * error.norm() <= kOutlierSigmas * sigma_px);
}

std::size_t countOutliers(const ViewFit& fit, double sigma_px) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < fit.errors.size(); ++i) {
    if (isOutlier(fit.corners[i], fit.errors[i], sigma_px)) ++count;
  }
  return count;
}

double misfitRatio(const ViewFit& fit, double sigma_px) {
  double sum = 0;
  for (std::size_t i = 0; i < fit.errors.size(); ++i) {
    const bool is_outlier = isOutlier(fit.corners[i], fit.errors[i], sigma_px);
    sum += is_outlier ? kOutlierSigmas * kOutlierSigmas
                      : fit.corners[i].weight * fit.errors[i].squaredNorm() / (sigma_px * sigma_px);
  }
  return std::sqrt(0.5 * sum / static_cast<double>(fit.errors.size()));
}

bool isExplained(const ViewFit& fit, double sigma_px) {
  constexpr double kExplained = 2;
  return countOutliers(fit, sigma_px) == 0 && misfitRatio(fit, sigma_px) < kExplained;
}

bool isSmooth(const Board& board, const ViewFit& view) {
  constexpr double kSmooth = 1.5;  // times the difference between neighbours
  double sum = 0;
  for (std::size_t i = 0; i < view.errors.size(); ++i)
    sum += view.corners[i].weight * view.errors[i].squaredNorm();
  const double rms = std::sqrt(0.5 * sum / static_cast<double>(view.errors.size()));
  NeighbourDifferences local;
  local.add(board, view.corners, view.errors);
  return rms > kSmooth * local.sigma();
}

double standOutRatio(std::vector<double> ratios) {
  constexpr double kTimes = 3;        // times the typical ratio
  constexpr double kDeviations = 4;   // above the typical ratio
  constexpr double kNormal = 1.4826;  // median absolute deviation to standard deviation
  const double typical = medianOf(ratios);
  for (double& ratio : ratios) ratio = std::abs(ratio - typical);
  return std::max(kTimes * std::max(1.0, typical), typical + kDeviations * kNormal * medianOf(ratios));
}

bool isForeign(const Fit& fit, const ViewFit& view, double stand_out_ratio) {
  constexpr std::size_t kMaxOutlierShare = 4;  // one in four
  const double sigma_px = noiseSigma(fit);
  const std::size_t num_outliers = countOutliers(view, sigma_px);
  if (view.errors.size() - num_outliers < kMinCornersPerView) return true;
  if (misfitRatio(view, sigma_px) < stand_out_ratio) return false;
  return kMaxOutlierShare * num_outliers > view.errors.size() ||
         isSmooth(fit.boards[view.board].target, view);
}

}  // namespace alidade
