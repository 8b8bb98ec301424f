// SPDX-License-Identifier: MIT
#include "alidade/calibrate/leverage.h"

#include <Eigen/LU>

#include "alidade/calibrate/corner_groups.h"
#include "alidade/calibrate/covariance.h"
#include "alidade/calibrate/view_kernel.h"

namespace alidade {
namespace {

// Joint covariance of a view's pose and the parameters, for corners of variance 1: the rows say how far the
// parameters take the pose with them, and how uncertain it is besides.
Eigen::MatrixXd jointCovariance(const PoseRows& rows, const Eigen::MatrixXd& params_cov) {
  const Eigen::Index n = params_cov.rows();
  const Eigen::Matrix<double, 6, 6> root = rows.leftCols<6>().inverse();
  const Eigen::MatrixXd pose_from_params = -root * rows.middleCols(6, n);
  Eigen::MatrixXd joint(6 + n, 6 + n);
  joint.bottomRightCorner(n, n) = params_cov;
  joint.topRightCorner(6, n) = pose_from_params * params_cov;
  joint.bottomLeftCorner(n, 6) = joint.topRightCorner(6, n).transpose();
  joint.topLeftCorner<6, 6>() =
      root * root.transpose() + joint.topRightCorner(6, n) * pose_from_params.transpose();
  return joint;
}

}  // namespace

std::vector<std::vector<double>> leverages(std::string_view model_id,
                                           std::span<const std::vector<Observation>> views,
                                           const BundleState& state, const ParamConstraint& constraint) {
  const ViewKernel& kernel = viewKernel(model_id);
  const Eigen::Index n = kernel.numParams();
  const CornerGroups corners(views);
  // Intrinsics that these views do not determine take little from the errors in any direction they do.
  const Eigen::MatrixXd params_cov =
      intrinsicsInformation(model_id, views, state, constraint).inverse.value_or(Eigen::MatrixXd::Zero(n, n));
  PoseRows rows(6, n + 7);
  SharedSums unused(kernel.numParams());
  std::vector<std::vector<double>> all;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const SE3& pose = state.camera_from_board[v];
    static_cast<void>(
        kernel.reduce(state.params.data(), pose, corners.view(v), kNoLoss, Unseen::kLeaveOut, rows, unused));
    all.emplace_back(views[v].size());
    kernel.quadraticForms(state.params.data(), pose, corners.view(v), jointCovariance(rows, params_cov),
                          all.back());
  }
  return all;
}

}  // namespace alidade
