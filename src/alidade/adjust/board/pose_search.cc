// SPDX-License-Identifier: MIT
#include "alidade/adjust/board/pose_search.h"

#include <cmath>
#include <limits>

#include "alidade/adjust/board/errors.h"
#include "alidade/adjust/board/view_pose.h"
#include "alidade/core/mapped.h"
#include "alidade/core/median.h"

namespace alidade {
namespace {

Eigen::Vector3d meanPoint(std::span<const Observation> view) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Observation& corner : view) sum += corner.p_board;
  return sum / static_cast<double>(view.size());
}

std::vector<std::vector<Observation>> cornersOfViews(const Fit& fit) {
  return mapped(fit.views, [&](const FitView& view) { return cornersOnShape(fit, view); });
}

}  // namespace

HuberLoss startLoss(ImageSize size) {
  return {.threshold_px = 0.005 * std::hypot(size.width, size.height)};
}

bool improvePoses(std::string_view model_id, std::span<const std::vector<Observation>> views, HuberLoss loss,
                  PosedCamera& camera) {
  constexpr double kBetter = 0.99;  // of the cost: a larger reduction than a loose solve leaves possible
  const AnyCamera unprojector = cameraOf(model_id, camera.params);
  bool is_improved = false;
  std::vector<double> costs(views.size(), std::numeric_limits<double>::infinity());
  const auto costOf = [&](std::size_t v, const SE3& pose) {
    return viewCost(model_id, camera.params, pose, views[v], loss);
  };
  const auto consider = [&](std::size_t v, const SE3& pose) {
    const double cost = costOf(v, pose);
    if (!(cost < kBetter * costs[v])) return;
    camera.poses[v] = pose;
    costs[v] = cost;
    is_improved = true;
  };
  for (std::size_t v = 0; v < views.size(); ++v) {
    if (camera.poses[v]) costs[v] = costOf(v, *camera.poses[v]);
    if (const auto pose = poseFromCorners(unprojector, views[v])) consider(v, *pose);
  }
  // A wrong tilt may have distorted the camera so that its rays reproduce the tilt.
  constexpr double kStandsOut = 4;  // times the median of all views
  const auto perCorner = [&](std::size_t v) { return costs[v] / static_cast<double>(views[v].size()); };
  std::vector<double> all;
  for (std::size_t v = 0; v < views.size(); ++v) all.push_back(perCorner(v));
  const double typical = medianOf(all);
  for (std::size_t v = 0; v < views.size(); ++v) {
    if (!camera.poses[v] || !(perCorner(v) > kStandsOut * typical)) continue;
    const SE3 mirrored = mirroredTilt(*camera.poses[v], meanPoint(views[v]));
    if (const auto pose = refitPose(model_id, camera.params, views[v], loss, mirrored)) consider(v, *pose);
  }
  return is_improved;
}

bool improvePoses(Fit& fit) {
  const FitCamera& camera = onlyCamera(fit);
  PosedCamera posed{.params = camera.params, .poses = {}};
  for (const FitView& view : fit.views) posed.poses.emplace_back(cameraFromBoard(fit, view));
  if (!improvePoses(camera.model, cornersOfViews(fit), fit.loss, posed)) return false;
  for (std::size_t v = 0; v < fit.views.size(); ++v) setCameraFromBoard(fit, fit.views[v], *posed.poses[v]);
  return true;
}

std::optional<Fit> posedAnew(Fit fit) {
  const FitCamera& camera = onlyCamera(fit);
  PosedCamera posed{.params = camera.params, .poses = {}};
  posed.poses.resize(fit.views.size());
  improvePoses(camera.model, cornersOfViews(fit), fit.loss, posed);
  for (std::size_t v = 0; v < fit.views.size(); ++v) {
    if (!posed.poses[v]) return std::nullopt;
    setCameraFromBoard(fit, fit.views[v], *posed.poses[v]);
  }
  return fit;
}

}  // namespace alidade
