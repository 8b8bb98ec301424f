// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <ceres/cost_function.h>
#include <Eigen/Core>

#include "alidade/calibrate/reprojection.h"
#include "alidade/calibrate/se3_manifold.h"

namespace alidade {

/// A board point and where it was seen.
struct Observation {
  Eigen::Vector3d p_board;
  Eigen::Vector2d pixel;
};

/// Huber's loss on a corner's squared error s = dx^2 + dy^2: rho(s) = s up to threshold^2, then linear in the
/// error.
struct HuberLoss {
  double threshold_px;

  [[nodiscard]] double rho(double s) const {
    if (s <= threshold_px * threshold_px) return s;
    return 2 * threshold_px * std::sqrt(s) - threshold_px * threshold_px;
  }
  /// d rho / d s: the weight of the corner.
  [[nodiscard]] double weight(double s) const {
    return s <= threshold_px * threshold_px ? 1.0 : threshold_px / std::sqrt(s);
  }
};

/// All corners of one view as one residual block, with the robust loss on each corner inside it. Parameter
/// blocks: intrinsics (kNumParams<M>), pose (7, SE3Manifold).
///
/// Residuals: two rows a corner, scaled by the root of its weight, so that gradient and Gauss-Newton matrix
/// are those of iteratively reweighted least squares; and a last row that carries what is missing to the
/// robust cost, sqrt(sum rho - sum weight s) >= 0, with a zero Jacobian: the solver sees the exact cost and
/// its exact gradient.
template <CameraModel M>
class ViewCost final : public ceres::CostFunction {
 public:
  ViewCost(std::vector<Observation> observations, HuberLoss loss)
      : observations_(std::move(observations)), loss_(loss) {
    mutable_parameter_block_sizes()->push_back(kNumParams<M>);
    mutable_parameter_block_sizes()->push_back(7);
    set_num_residuals(2 * static_cast<int>(observations_.size()) + 1);
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const SE3 camera_from_board = fromBlock(parameters[1]);
    const Eigen::Matrix3d R = camera_from_board.rotation.matrix();
    double* J_params = jacobians != nullptr ? jacobians[0] : nullptr;
    double* J_pose = jacobians != nullptr ? jacobians[1] : nullptr;
    Eigen::Matrix<double, 6, 7, Eigen::RowMajor> tangent_from_ambient;
    if (J_pose != nullptr) SE3Manifold().MinusJacobian(parameters[1], tangent_from_ambient.data());

    Reprojection<M> corner;
    double missing = 0;
    for (const Observation& observation : observations_) {
      if (!reproject<M>(parameters[0], R, camera_from_board.translation, observation.p_board, corner))
        return false;
      const Eigen::Vector2d error = corner.pixel - observation.pixel;
      const double s = error.squaredNorm();
      const double weight = loss_.weight(s);
      const double root = std::sqrt(weight);
      missing += loss_.rho(s) - weight * s;
      *residuals++ = root * error.x();
      *residuals++ = root * error.y();
      if (J_params != nullptr) {
        Eigen::Map<decltype(corner.J_px_params)>(J_params).noalias() = root * corner.J_px_params;
        J_params += 2 * kNumParams<M>;
      }
      if (J_pose != nullptr) {
        // Ceres multiplies by the manifold's PlusJacobian, which takes this back to the tangent.
        Eigen::Map<Eigen::Matrix<double, 2, 7, Eigen::RowMajor>>(J_pose).noalias() =
            (root * corner.J_px_pose) * tangent_from_ambient;
        J_pose += 2 * 7;
      }
    }
    *residuals = std::sqrt(std::max(0.0, missing));
    if (J_params != nullptr) std::fill_n(J_params, kNumParams<M>, 0.0);
    if (J_pose != nullptr) std::fill_n(J_pose, 7, 0.0);
    return true;
  }

 private:
  std::vector<Observation> observations_;
  HuberLoss loss_;
};

}  // namespace alidade
