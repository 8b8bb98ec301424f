// SPDX-License-Identifier: MIT
#include "alidade/calibrate/leverage.h"

#include "alidade/calibrate/covariance.h"
#include "alidade/calibrate/normal_blocks.h"
#include "alidade/camera/model_list.h"

namespace alidade {
namespace {

template <CameraModel M>
std::vector<double> leveragesOfView(const BundleState& state, const SE3& pose,
                                    const std::vector<Observation>& view,
                                    const Eigen::Matrix<double, kNumParams<M>, kNumParams<M>>& params_cov) {
  const detail::NormalBlocks<M> blocks(state.params.data(), pose, view);
  const auto pose_factor = blocks.pose_pose.ldlt();
  const Eigen::Matrix<double, 6, 6> pose_cov = pose_factor.solve(Eigen::Matrix<double, 6, 6>::Identity());
  const Eigen::Matrix<double, 6, kNumParams<M>> pose_from_params = -pose_cov * blocks.pose_params;
  const Eigen::Matrix3d R = pose.rotation.matrix();
  std::vector<double> leverages(view.size(), 0.0);
  Reprojection<M> corner;
  for (std::size_t i = 0; i < view.size(); ++i) {
    if (!reproject<M>(state.params.data(), R, pose.translation, view[i].p_board, corner)) continue;
    // How the corner moves with the intrinsics when the pose follows.
    const Eigen::Matrix<double, 2, kNumParams<M>> J_following =
        corner.J_px_params + corner.J_px_pose * pose_from_params;
    const double by_pose = (corner.J_px_pose * pose_cov).cwiseProduct(corner.J_px_pose).sum();
    const double by_params = (J_following * params_cov).cwiseProduct(J_following).sum();
    leverages[i] = view[i].weight * (by_pose + by_params);
  }
  return leverages;
}

}  // namespace

std::vector<std::vector<double>> leverages(std::string_view model_id,
                                           std::span<const std::vector<Observation>> views,
                                           const BundleState& state, const ParamConstraint& constraint) {
  const auto inverse = intrinsicsInformation(model_id, views, state, constraint).inverse;
  std::vector<std::vector<double>> all;
  forEachModel(AllModels{}, [&](auto tag) {
    using M = typename decltype(tag)::Model;
    if (M::kId != model_id) return;
    // Intrinsics that these views do not determine take little from the errors in any direction they do.
    Eigen::Matrix<double, kNumParams<M>, kNumParams<M>> params_cov;
    params_cov.setZero();
    if (inverse) params_cov = *inverse;
    for (std::size_t v = 0; v < views.size(); ++v) {
      all.push_back(leveragesOfView<M>(state, state.camera_from_board[v], views[v], params_cov));
    }
  });
  return all;
}

}  // namespace alidade
