// SPDX-License-Identifier: MIT
#include "alidade/adjust/pose_refit.h"

#include <Eigen/LU>

namespace alidade {
namespace {

struct Evaluation {
  double cost = 0;  // sum of rho
  double drop = 0;  // what the step takes off it, as far as a parabola says
  SE3::Vec6 step = SE3::Vec6::Zero();
};

std::optional<Evaluation> evaluate(const ViewKernel& kernel, std::span<const double> params,
                                   std::span<const CornerGroup> corners, HuberLoss loss, const SE3& pose,
                                   ViewFactor& factor) {
  if (!kernel.factor(params.data(), pose, corners, loss, Unseen::kRefuse, factor.data())) return std::nullopt;
  const SE3::Vec6 y = factor.topRightCorner<6, 1>();
  const Eigen::Matrix<double, 6, 6> R = factor.topLeftCorner<6, 6>();
  return Evaluation{.cost = factor.rightCols<1>().squaredNorm(),
                    .drop = y.squaredNorm(),
                    .step = -R.partialPivLu().solve(y)};
}

}  // namespace

std::optional<SE3> refitPose(const ViewKernel& kernel, std::span<const double> params,
                             std::span<const CornerGroup> corners, HuberLoss loss,
                             const SE3& camera_from_board) {
  constexpr int kMaxSteps = 30;
  constexpr int kMaxHalvings = 12;
  constexpr double kAtRest = 1e-10;  // of the cost
  SE3 pose = camera_from_board;
  ViewFactor factor(kernel.numParams() + 7, kernel.numParams() + 7);
  auto at = evaluate(kernel, params, corners, loss, pose, factor);
  if (!at) return std::nullopt;
  // A pose that has not come to rest by then is merely worse than it could be.
  for (int i = 0; i < kMaxSteps && at->drop > kAtRest * at->cost; ++i) {
    SE3::Vec6 step = at->step;
    bool is_lower = false;
    for (int k = 0; k < kMaxHalvings && !is_lower; ++k, step *= 0.5) {
      const SE3 moved = pose * SE3::exp(step);
      const auto there = evaluate(kernel, params, corners, loss, moved, factor);
      if (!there || !(there->cost < at->cost)) continue;
      pose = moved;
      at = there;
      is_lower = true;
    }
    if (!is_lower) break;
  }
  return pose;
}

std::optional<SE3> refitPose(std::string_view model_id, std::span<const double> params,
                             std::span<const Observation> corners, HuberLoss loss,
                             const SE3& camera_from_board) {
  return refitPose(viewKernel(model_id), params, CornerGroups(corners).view(0), loss, camera_from_board);
}

}  // namespace alidade
