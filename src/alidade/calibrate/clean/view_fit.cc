// SPDX-License-Identifier: MIT
#include "alidade/calibrate/clean/view_fit.h"

#include <algorithm>
#include <cmath>
#include <functional>
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

ViewFit viewFit(const Fit& fit, std::size_t board_index, const BoardShape& shape,
                const SE3& camera_from_board, std::vector<Observation> corners) {
  const FitCamera& camera = onlyCamera(fit);
  const FitBoard& board = fit.boards[board_index];
  ViewFit of{.board = board_index,
             .camera_from_board = camera_from_board,
             .corners = std::move(corners),
             .errors = {},
             .sigma_px = noiseSigma(fit)};
  of.errors = reprojectionErrors(camera.model, camera.params, camera_from_board,
                                 onShape(board.target, shape, of.corners));
  return of;
}

}  // namespace

ViewFit fitInUse(const Fit& fit, std::size_t v, const View& view) {
  return viewFit(fit, view.board, shapeIn(fit.boards[view.board], fit.views[v]),
                 cameraFromBoard(fit, fit.views[v]), weightedCorners(fit, view));
}

std::optional<ViewFit> fitAlone(const Fit& fit, const View& view) {
  return fitAlone(fit, cameraOf(fit), view);
}

std::optional<ViewFit> fitAlone(const Fit& fit, const AnyCamera& camera, const View& view) {
  const FitBoard& board = fit.boards[view.board];
  std::vector<Observation> corners = weightedCorners(fit, view);
  const auto pose = poseFromCorners(camera, corners);
  if (!pose) return std::nullopt;
  const auto refined = refitPose(onlyCamera(fit).model, onlyCamera(fit).params,
                                 onShape(board.target, board.shape, corners), fit.loss, *pose);
  if (!refined) return std::nullopt;
  return viewFit(fit, view.board, board.shape, *refined, std::move(corners));
}

bool ViewFit::isOutlier(std::size_t corner) const {
  return !(std::sqrt(corners[corner].weight) * errors[corner].norm() <= kOutlierSigmas * sigma_px);
}

std::size_t ViewFit::countOutliers() const {
  std::size_t count = 0;
  for (std::size_t i = 0; i < errors.size(); ++i) count += isOutlier(i) ? 1 : 0;
  return count;
}

double ViewFit::misfitRatio() const {
  double sum = 0;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    sum += isOutlier(i) ? kOutlierSigmas * kOutlierSigmas
                        : corners[i].weight * errors[i].squaredNorm() / (sigma_px * sigma_px);
  }
  return std::sqrt(0.5 * sum / static_cast<double>(errors.size()));
}

bool ViewFit::isExplained() const {
  constexpr double kExplained = 2;
  return countOutliers() == 0 && misfitRatio() < kExplained;
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
  const std::size_t num_outliers = view.countOutliers();
  if (view.errors.size() - num_outliers < kMinCornersPerView) return true;
  if (view.misfitRatio() < stand_out_ratio) return false;
  return kMaxOutlierShare * num_outliers > view.errors.size() ||
         isSmooth(fit.boards[view.board].target, view);
}

std::vector<std::pair<std::string, View>> renumberings(const Board& board, const View& view) {
  const int columns = board.columns();
  const int rows = board.rows();
  const int count = board.numCorners();
  const auto around = [](int i, int n) { return (i + n) % n; };
  const auto columnsOn = [&](int step) {
    return [=](int id) { return id / columns * columns + around(id % columns + step, columns); };
  };
  const auto idsOn = [&](int step) { return [=](int id) { return around(id + step, count); }; };
  const std::vector<std::pair<std::string, std::function<int(int)>>> orders = {
      {"column by column instead of row by row", [=](int id) { return id % rows * columns + id / rows; }},
      {"one column further in each row", columnsOn(1)},
      {"one column back in each row", columnsOn(-1)},
      {"one further", idsOn(1)},
      {"one back", idsOn(-1)},
      {"one row further", idsOn(columns)},
      {"one row back", idsOn(-columns)}};
  std::vector<std::pair<std::string, View>> all;
  for (const auto& [how, renumbered] : orders) {
    std::vector<Corner>& corners = all.emplace_back(how, view).second.corners;
    for (Corner& corner : corners) corner.id = renumbered(corner.id);
    std::ranges::sort(corners, {}, &Corner::id);
  }
  return all;
}

std::optional<std::string> fittingOrder(const Fit& fit, const View& view) {
  const AnyCamera camera = cameraOf(fit);
  for (const auto& [how, renumbered] : renumberings(fit.boards[view.board].target, view)) {
    const auto alone = fitAlone(fit, camera, renumbered);
    if (alone && alone->isExplained()) return how;
  }
  return std::nullopt;
}

}  // namespace alidade
