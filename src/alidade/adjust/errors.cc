// SPDX-License-Identifier: MIT
#include "alidade/adjust/errors.h"

#include <cmath>

#include "alidade/adjust/corner_groups.h"
#include "alidade/adjust/view_kernel.h"

namespace alidade {

std::vector<Eigen::Vector2d> reprojectionErrors(std::string_view model_id, std::span<const double> params,
                                                const SE3& camera_from_board,
                                                std::span<const Observation> corners) {
  std::vector<Eigen::Vector2d> errors(corners.size());
  viewKernel(model_id).errors(params.data(), camera_from_board, CornerGroups(corners).view(0), errors);
  return errors;
}

std::vector<Eigen::Vector2d> viewErrors(const Fit& fit, const FitView& view) {
  const FitCamera& camera = fit.cameras[view.camera];
  return reprojectionErrors(camera.model, camera.params, cameraFromBoard(fit, view),
                            cornersOnShape(fit, view));
}

double viewCost(std::string_view model_id, std::span<const double> params, const SE3& pose,
                std::span<const Observation> corners, HuberLoss loss) {
  double cost = 0;
  const auto errors = reprojectionErrors(model_id, params, pose, corners);
  for (std::size_t i = 0; i < errors.size(); ++i)
    cost += 0.5 * loss.rho(corners[i].weight * errors[i].squaredNorm());
  return cost;
}

std::vector<Eigen::Vector2d> weightedErrors(const Fit& fit) {
  std::vector<Eigen::Vector2d> errors;
  for (const FitView& view : fit.views) {
    for (std::size_t i = 0; i < view.errors.size(); ++i)
      errors.emplace_back(std::sqrt(view.corners[i].weight) * view.errors[i]);
  }
  return errors;
}

double meanWeightedSquare(const Fit& fit) {
  double sum = 0;
  std::size_t count = 0;
  for (const FitView& view : fit.views) {
    for (std::size_t i = 0; i < view.errors.size(); ++i)
      sum += view.corners[i].weight * view.errors[i].squaredNorm();
    count += view.errors.size();
  }
  return sum / static_cast<double>(count);
}

double weightedRms(const Fit& fit) {
  return std::sqrt(meanWeightedSquare(fit));
}

double rms(const Fit& fit) {
  double sum = 0;
  std::size_t count = 0;
  for (const FitView& view : fit.views) {
    for (const Eigen::Vector2d& error : view.errors) sum += error.squaredNorm();
    count += view.errors.size();
  }
  return std::sqrt(sum / static_cast<double>(count));
}

}  // namespace alidade
