// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "alidade/calibrate/reprojection.h"
#include "alidade/calibrate/view_cost.h"
#include "alidade/geometry/se3.h"

namespace alidade::detail {

/// The blocks of J^T W J that one view adds, W being the corners' weights. Corners that do not project are
/// left out.
template <CameraModel M>
struct NormalBlocks {
  Eigen::Matrix<double, 6, 6> pose_pose = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, kNumParams<M>> pose_params = Eigen::Matrix<double, 6, kNumParams<M>>::Zero();
  Eigen::Matrix<double, kNumParams<M>, kNumParams<M>> params_params =
      Eigen::Matrix<double, kNumParams<M>, kNumParams<M>>::Zero();

  NormalBlocks(const double* params, const SE3& camera_from_board, std::span<const Observation> view) {
    const Eigen::Matrix3d R = camera_from_board.rotation.matrix();
    Reprojection<M> corner;
    for (const Observation& observation : view) {
      if (!reproject<M>(params, R, camera_from_board.translation, observation.p_board, corner)) continue;
      const Eigen::Matrix<double, 2, 6, Eigen::RowMajor> weighted_pose =
          observation.weight * corner.J_px_pose;
      const Eigen::Matrix<double, 2, kNumParams<M>, Eigen::RowMajor> weighted_params =
          observation.weight * corner.J_px_params;
      pose_pose.noalias() += weighted_pose.transpose() * corner.J_px_pose;
      pose_params.noalias() += weighted_pose.transpose() * corner.J_px_params;
      params_params.noalias() += weighted_params.transpose() * corner.J_px_params;
    }
  }
};

}  // namespace alidade::detail
