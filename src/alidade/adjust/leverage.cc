// SPDX-License-Identifier: MIT
#include "alidade/adjust/leverage.h"

#include <Eigen/LU>

#include "alidade/adjust/corner_groups.h"
#include "alidade/adjust/covariance.h"
#include "alidade/adjust/view_kernel.h"

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

std::vector<std::vector<double>> leverages(const Fit& fit) {
  const FitCamera& camera = fit.cameras.front();
  const ViewKernel& kernel = viewKernel(camera.model);
  const Eigen::Index n = kernel.numParams();
  // Intrinsics that these views do not determine take little from the errors in any direction they do.
  const Eigen::MatrixXd params_cov = intrinsicsInformation(fit).inverse.value_or(Eigen::MatrixXd::Zero(n, n));
  PoseRows rows(6, n + 7);
  SharedSums unused(kernel.numParams());
  std::vector<std::vector<double>> all;
  for (const FitView& view : fit.views) {
    const SE3 pose = cameraFromBoard(fit, view);
    const CornerGroups corners(cornersOnShape(fit, view));
    static_cast<void>(
        kernel.reduce(camera.params.data(), pose, corners.view(0), kNoLoss, Unseen::kLeaveOut, rows, unused));
    all.emplace_back(view.corners.size());
    kernel.quadraticForms(camera.params.data(), pose, corners.view(0), jointCovariance(rows, params_cov),
                          all.back());
  }
  return all;
}

}  // namespace alidade
