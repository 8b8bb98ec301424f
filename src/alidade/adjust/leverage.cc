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
Eigen::MatrixXd jointCovariance(const ViewFactor& factor, const Eigen::MatrixXd& params_cov) {
  const Eigen::Index n = params_cov.rows();
  const Eigen::Matrix<double, 6, 6> root = factor.topLeftCorner<6, 6>().inverse();
  const Eigen::MatrixXd pose_from_params = -root * factor.block(0, 6, 6, n);
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
  const FitCamera& camera = onlyCamera(fit);
  const ViewKernel& kernel = viewKernel(camera.model);
  const Eigen::Index n = kernel.numParams();
  // Intrinsics that these views do not determine take little from the errors in any direction they do.
  const Eigen::MatrixXd params_cov = intrinsicsInformation(fit).inverse.value_or(Eigen::MatrixXd::Zero(n, n));
  std::vector<std::vector<double>> all;
  ViewFactor rows;
  for (const FitView& view : fit.views) {
    const SE3 pose = cameraFromBoard(fit, view);
    const CornerGroups corners(cornersOnShape(fit, view));
    const auto factor = viewFactor(kernel, camera.params, pose, corners.view(0), kNoLoss, Unseen::kLeaveOut);
    const Eigen::MatrixXd covariance = jointCovariance(*factor, params_cov);
    rows.resize(2 * static_cast<Eigen::Index>(view.corners.size()), n + 7);
    kernel.rows(camera.params.data(), pose, corners.view(0),
                {rows.data(), static_cast<std::size_t>(rows.size())});
    const Eigen::VectorXd forms =
        (rows.leftCols(n + 6) * covariance).cwiseProduct(rows.leftCols(n + 6)).rowwise().sum();
    std::vector<double>& of_view = all.emplace_back();
    for (Eigen::Index i = 0; i < forms.size(); i += 2) of_view.push_back(forms(i) + forms(i + 1));
  }
  return all;
}

}  // namespace alidade
