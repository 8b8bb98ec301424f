// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "alidade/camera/projection.h"

namespace alidade {

/// A corner's reprojection and its derivatives, all of fixed size.
template <CameraModel M>
struct Reprojection {
  Eigen::Vector2d pixel;
  Eigen::Matrix<double, 2, 6, Eigen::RowMajor>
      J_px_pose;  ///< by the tangent of T Exp([translation, rotation])
  Eigen::Matrix<double, 2, kNumParams<M>, Eigen::RowMajor> J_px_params;
};

/// Projects a board point through pose R, t (camera_from_board) and `params`. False behind the camera, beyond
/// a pole, or where the lens has folded: a solver must then reject the step.
template <CameraModel M>
bool reproject(const double* params, const Eigen::Matrix3d& R, const Eigen::Vector3d& t,
               const Eigen::Vector3d& p_board, Reprojection<M>& out) {
  const Eigen::Vector3d p_cam = R * p_board + t;
  Eigen::Matrix<double, 2, 3, Eigen::RowMajor> J_px_cam;
  if (!projectFormulaJacobian<M>(params, p_cam.data(), out.pixel.data(), J_px_cam.data(),
                                 out.J_px_params.data())) {
    return false;
  }
  // Sign of the Jacobian on the unit sphere, as in the domain certificate.
  if (!(J_px_cam.row(0).cross(J_px_cam.row(1)).dot(p_cam) > 0)) return false;
  // d p_cam / d translation = R, d p_cam / d rotation = -R hat(p_board).
  const Eigen::Matrix<double, 2, 3, Eigen::RowMajor> J_px_board = J_px_cam * R;
  out.J_px_pose.template leftCols<3>() = J_px_board;
  for (int i = 0; i < 2; ++i) {
    out.J_px_pose.template block<1, 3>(i, 3) = p_board.cross(J_px_board.row(i).transpose()).transpose();
  }
  return true;
}

}  // namespace alidade
