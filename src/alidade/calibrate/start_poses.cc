// SPDX-License-Identifier: MIT
#include "alidade/calibrate/start_poses.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "alidade/init/pose_from_rays.h"

namespace alidade {
namespace {

Eigen::Vector3d meanPoint(std::span<const Observation> view) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Observation& observation : view) sum += observation.p_board;
  return sum / static_cast<double>(view.size());
}

}  // namespace

std::vector<std::vector<Observation>> observationsOf(const Checkerboard& board, std::span<const View> views) {
  std::vector<std::vector<Observation>> all(views.size());
  for (std::size_t v = 0; v < views.size(); ++v) {
    for (const Corner& corner : views[v].corners) {
      all[v].push_back({board.corner(corner.id), corner.pixel, corner.sigma_px});
    }
  }
  return all;
}

HuberLoss startLoss(ImageSize size) {
  return {.threshold_px = 0.005 * std::hypot(size.width, size.height)};
}

double viewCost(std::string_view model_id, std::span<const double> params, const SE3& pose,
                std::span<const Observation> view, HuberLoss loss) {
  double cost = 0;
  for (const Eigen::Vector2d& error : reprojectionErrors(model_id, params, pose, view))
    cost += 0.5 * loss.rho(error.squaredNorm());
  return cost;
}

std::optional<SE3> refinedPose(std::string_view model_id, const std::vector<double>& params, const SE3& pose,
                               const std::vector<Observation>& view, HuberLoss loss) {
  constexpr int kMaxIterations = 100;
  constexpr double kTolerance = 1e-3;  // of the cost: a solve of all follows
  // A start that does not project is a view that cannot be posed, and not the solver's business.
  if (!std::isfinite(viewCost(model_id, params, pose, view, loss))) return std::nullopt;
  BundleState state{.params = params, .camera_from_board = {pose}};
  std::vector<int> all(params.size());
  std::iota(all.begin(), all.end(), 0);
  const BundleSummary summary = solveBundle(model_id, std::span(&view, 1), state,
                                            {.loss = loss,
                                             .max_iterations = kMaxIterations,
                                             .function_tolerance = kTolerance,
                                             .constraint = {.held = std::move(all)}});
  if (summary.termination == Termination::kFailed) return std::nullopt;
  return state.camera_from_board.front();
}

bool improvePoses(std::string_view model_id, const Checkerboard& board, std::span<const View> views,
                  HuberLoss loss, PosedCamera& camera) {
  constexpr double kBetter = 0.99;  // of the cost: more than what a loose solve leaves
  const AnyCamera unprojector = AnyCamera::make(model_id, camera.params);
  const auto observations = observationsOf(board, views);
  bool is_improved = false;
  std::vector<double> costs(views.size(), std::numeric_limits<double>::infinity());
  const auto consider = [&](std::size_t v, const SE3& pose) {
    const double cost = viewCost(model_id, camera.params, pose, observations[v], loss);
    if (!(cost < kBetter * costs[v])) return;
    camera.poses[v] = pose;
    costs[v] = cost;
    is_improved = true;
  };
  for (std::size_t v = 0; v < views.size(); ++v) {
    if (camera.poses[v])
      costs[v] = viewCost(model_id, camera.params, *camera.poses[v], observations[v], loss);
    if (const auto pose = poseFromView(unprojector, board, views[v].corners)) consider(v, *pose);
  }
  // A wrong tilt may have bent the camera to itself, so that its rays lead back to it.
  constexpr double kStandsOut = 4;  // times the median of all views
  const auto perCorner = [&](std::size_t v) {
    return costs[v] / static_cast<double>(observations[v].size());
  };
  std::vector<double> sorted;
  for (std::size_t v = 0; v < views.size(); ++v) sorted.push_back(perCorner(v));
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  for (std::size_t v = 0; v < views.size(); ++v) {
    if (!camera.poses[v] || !(perCorner(v) > kStandsOut * *middle)) continue;
    const SE3 mirrored = mirroredTilt(*camera.poses[v], meanPoint(observations[v]));
    if (const auto pose = refinedPose(model_id, camera.params, mirrored, observations[v], loss))
      consider(v, *pose);
  }
  return is_improved;
}

}  // namespace alidade
