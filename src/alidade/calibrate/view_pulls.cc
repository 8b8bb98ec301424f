// SPDX-License-Identifier: MIT
#include "alidade/calibrate/view_pulls.h"

#include <Eigen/Cholesky>

#include "alidade/calibrate/corner_groups.h"
#include "alidade/calibrate/reprojection.h"
#include "alidade/calibrate/view_kernel.h"
#include "alidade/camera/model_list.h"
#include "alidade/core/error.h"
#include "alidade/target/board_shape.h"

namespace alidade {
namespace {

template <CameraModel M>
ViewPull pullWithBend(const Checkerboard& board, std::span<const Observation> view, const double* params,
                      const SE3& pose, HuberLoss loss, LossWeights weights) {
  constexpr int kParams = kNumParams<M>;
  constexpr int kGlobal = kParams + kNumBends;
  Eigen::Matrix<double, kGlobal, kGlobal> information = Eigen::Matrix<double, kGlobal, kGlobal>::Zero();
  Eigen::Matrix<double, kGlobal, 1> gradient = Eigen::Matrix<double, kGlobal, 1>::Zero();
  Eigen::Matrix<double, 6, 6> pose_pose = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, kGlobal> pose_global = Eigen::Matrix<double, 6, kGlobal>::Zero();
  Eigen::Matrix<double, 6, 1> pose_gradient = Eigen::Matrix<double, 6, 1>::Zero();
  const Eigen::Matrix3d R = pose.rotation.matrix();
  Reprojection<M> corner;
  for (const Observation& observation : view) {
    const Eigen::Vector3d& p = observation.p_board;
    if (!reproject<M>(params, R, pose.translation, p, corner)) continue;
    Eigen::Matrix<double, 2, kGlobal, Eigen::RowMajor> J;
    J.template leftCols<kParams>() = corner.J_px_params;
    // A shift of the board along its own z is a shift of the point.
    J.template rightCols<kNumBends>() =
        corner.J_px_pose.col(2) * bendProfile(board, p.x(), p.y()).transpose();
    const Eigen::Vector2d error = corner.pixel - observation.pixel;
    const double robust = loss.weight(observation.weight * error.squaredNorm());
    const double weight = observation.weight * (weights == LossWeights::kUse ? robust : 1.0);
    const Eigen::Vector2d psi = observation.weight * robust * error;
    pose_pose.noalias() += weight * corner.J_px_pose.transpose() * corner.J_px_pose;
    pose_global.noalias() += weight * corner.J_px_pose.transpose() * J;
    pose_gradient.noalias() += corner.J_px_pose.transpose() * psi;
    information.noalias() += weight * J.transpose() * J;
    gradient.noalias() += J.transpose() * psi;
  }
  const auto factor = pose_pose.ldlt();
  information -= pose_global.transpose() * factor.solve(pose_global);
  gradient -= pose_global.transpose() * factor.solve(pose_gradient);
  return {0.5 * (information + information.transpose()), gradient};
}

}  // namespace

std::vector<ViewPull> viewPulls(std::string_view model_id, std::span<const std::vector<Observation>> views,
                                const BundleState& state, HuberLoss loss) {
  const ViewKernel& kernel = viewKernel(model_id);
  const Eigen::Index n = kernel.numParams();
  const CornerGroups corners(views);
  PoseRows rows(6, n + 7);
  std::vector<ViewPull> pulls;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const auto reduce = [&](HuberLoss with) {
      SharedSums sums(kernel.numParams());
      static_cast<void>(kernel.reduce(state.params.data(), state.camera_from_board[v], corners.view(v), with,
                                      Unseen::kLeaveOut, rows, sums));
      return sums.gram;
    };
    const Eigen::MatrixXd plain = reduce(kNoLoss);
    pulls.push_back({.information = plain.topLeftCorner(n, n).selfadjointView<Eigen::Lower>(),
                     .gradient = reduce(loss).row(n).head(n).transpose()});
  }
  return pulls;
}

std::vector<ViewPull> viewPullsWithBend(std::string_view model_id, const Checkerboard& board,
                                        std::span<const std::vector<Observation>> views,
                                        const BundleState& state, HuberLoss loss, LossWeights weights) {
  std::vector<ViewPull> pulls;
  forEachModel(AllModels{}, [&](auto tag) {
    using M = typename decltype(tag)::Model;
    if (M::kId != model_id) return;
    for (std::size_t v = 0; v < views.size(); ++v) {
      pulls.push_back(
          pullWithBend<M>(board, views[v], state.params.data(), state.camera_from_board[v], loss, weights));
    }
  });
  expect(!pulls.empty(), "there are views, and the model's id is known");
  return pulls;
}

}  // namespace alidade
