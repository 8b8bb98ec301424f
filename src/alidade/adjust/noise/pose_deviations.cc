// SPDX-License-Identifier: MIT
#include "alidade/adjust/noise/pose_deviations.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/board/reduced.h"
#include "alidade/core/mapped.h"
#include "alidade/core/median.h"
#include "alidade/geometry/decompositions.h"

namespace alidade {
namespace {

constexpr Eigen::Index kPose = 6;
constexpr Eigen::Index kOwn = PoseDeviation::kSize;

// The equations of a placement's pose and of the deviations of its views, with the cameras and boards held.
Eigen::MatrixXd placementInformation(const Fit& fit, const std::vector<const FitView*>& views,
                                     const std::vector<Matrix6d>& of_views) {
  const Eigen::Index size = kPose + kOwn * std::ssize(views);
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(size, size);
  information.diagonal().tail(size - kPose).setOnes();
  Eigen::Index at = kPose;
  for (std::size_t i = 0; i < views.size(); ++i, at += kOwn) {
    const Vector6d tangent = deviationTangent(fit, *views[i]);
    Eigen::Matrix<double, kPose, kPose + kOwn> J;
    J << SE3::exp(-tangent).adjoint() * boardOf(fit, *views[i]).tangentByBody(),
        SE3::rightJacobian(tangent) * views[i]->deviation->root;
    const Eigen::Matrix<double, kPose + kOwn, kPose + kOwn> both = J.transpose() * of_views[i] * J;
    information.topLeftCorner<kPose, kPose>() += both.topLeftCorner<kPose, kPose>();
    information.block<kOwn, kPose>(at, 0) = both.bottomLeftCorner<kOwn, kPose>();
    information.block<kPose, kOwn>(0, at) = both.topRightCorner<kPose, kOwn>();
    information.block<kOwn, kOwn>(at, at) += both.bottomRightCorner<kOwn, kOwn>();
  }
  return information;
}

Matrix6d poseInformation(const Fit& fit, const FitView& view) {
  const FitCamera& camera = fit.cameras[view.camera];
  return detail::gramOf(camera.model, camera.params, cameraFromBoard(fit, view), cornersOnShape(fit, view),
                        fit.loss, LossWeights::kUse)
      .lower.topLeftCorner<kPose, kPose>()
      .selfadjointView<Eigen::Lower>();
}

// Sums over coordinates of one kind.
struct Part {
  double squares = 0;
  double num_free = 0;  // number that the corners determine, not the scatter

  [[nodiscard]] double factor() const { return num_free > 0 ? std::sqrt(squares / num_free) : 0; }
};

struct OfView {
  Part time = {};
  Part path = {};
  double shift = 0;  // squared, summed over corners, in their variances
};

}  // namespace

DeviationScatter deviationScatter(const Fit& fit) {
  constexpr double kFar = 3;
  std::map<std::size_t, std::vector<std::size_t>> placements;
  for (std::size_t v = 0; v < fit.views.size(); ++v) {
    if (fit.views[v].deviation) placements[fit.views[v].placement].push_back(v);
  }
  DeviationScatter scatter{.sizes = std::vector<double>(fit.views.size())};
  std::map<std::size_t, OfView> of_views;
  std::vector<double> sizes;
  for (const auto& [placement, views] : placements) {
    const std::vector<const FitView*> of_placement =
        mapped(views, [&](std::size_t v) { return &fit.views[v]; });
    const std::vector<Matrix6d> information =
        mapped(views, [&](std::size_t v) { return poseInformation(fit, fit.views[v]); });
    const Eigen::VectorXd variances =
        inverseSpd(placementInformation(fit, of_placement, information)).diagonal();
    Eigen::Index at = kPose;
    for (std::size_t i = 0; i < views.size(); ++i, at += kOwn) {
      const PoseDeviation::Normal& normal = of_placement[i]->deviation->normal;
      const Vector6d tangent = deviationTangent(fit, *of_placement[i]);
      const OfView own = {.time = {.squares = normal(0) * normal(0), .num_free = 1 - variances(at)},
                          .path = {.squares = normal.tail<kOwn - 1>().squaredNorm(),
                                   .num_free = kOwn - 1 - variances.segment<kOwn - 1>(at + 1).sum()},
                          .shift = tangent.dot(information[i] * tangent)};
      of_views[views[i]] = own;
      constexpr double kLeastFree = 1e-9;  // rounding may make it negative where corners say nothing
      const double own_free = std::max(kLeastFree, own.time.num_free + own.path.num_free);
      sizes.push_back(std::sqrt((own.time.squares + own.path.squares) / own_free));
      scatter.sizes[views[i]] = sizes.back();
    }
  }
  if (sizes.empty()) return scatter;
  scatter.usual_size = medianOf(std::move(sizes));
  OfView sum;
  double num_coordinates = 0;
  for (const auto& [v, own] : of_views) {
    scatter.num_free += own.time.num_free + own.path.num_free;
    if (scatter.sizes[v] > kFar * scatter.usual_size) continue;
    for (Part OfView::*part : {&OfView::time, &OfView::path}) {
      (sum.*part).squares += (own.*part).squares;
      (sum.*part).num_free += (own.*part).num_free;
    }
    sum.shift += own.shift;
    num_coordinates += 2 * static_cast<double>(fit.views[v].corners.size());
  }
  scatter.time_factor = sum.time.factor();
  scatter.path_factor = sum.path.factor();
  scatter.shift_sigmas = std::sqrt(sum.shift / num_coordinates);
  return scatter;
}

}  // namespace alidade
