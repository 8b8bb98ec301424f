// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include <ceres/manifold.h>
#include <ceres/normal_prior.h>
#include <Eigen/Core>

#include "alidade/geometry/se3.h"

namespace alidade {

/// A pose as the solver holds it: [qx qy qz qw tx ty tz], metres.
using PoseBlock = std::array<double, 7>;

[[nodiscard]] inline PoseBlock toBlock(const SE3& pose) {
  const Eigen::Quaterniond& q = pose.rotation.quaternion();
  const Eigen::Vector3d& t = pose.translation;
  return {q.x(), q.y(), q.z(), q.w(), t.x(), t.y(), t.z()};
}

[[nodiscard]] inline SE3 fromBlock(const double* block) {
  SE3 pose;
  pose.rotation = SO3::fromQuaternion(Eigen::Quaterniond(block[3], block[0], block[1], block[2]));
  pose.translation = Eigen::Vector3d(block[4], block[5], block[6]);
  return pose;
}

/// SE(3) for Ceres with this project's tangent: T Exp(xi), xi = [translation, rotation] in metres and true
/// radians (Ceres' own quaternion manifolds use half angles, which would make every rotation variance a
/// quarter).
class SE3Manifold final : public ceres::Manifold {
 public:
  [[nodiscard]] int AmbientSize() const override { return 7; }
  [[nodiscard]] int TangentSize() const override { return 6; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;
};

/// Derivative of the tangent at a pose by the seven numbers of its block.
[[nodiscard]] inline Eigen::Matrix<double, 6, 7, Eigen::RowMajor> tangentByBlock(const double* pose) {
  Eigen::Matrix<double, 6, 7, Eigen::RowMajor> J;
  SE3Manifold().MinusJacobian(pose, J.data());
  return J;
}

/// One residual per parameter: (parameter - mean) / deviation.
/// @param inverse_deviations  0 for a parameter without prior knowledge
[[nodiscard]] inline ceres::CostFunction* priorBlock(const Eigen::VectorXd& inverse_deviations,
                                                     const Eigen::VectorXd& mean) {
  return new ceres::NormalPrior(inverse_deviations.asDiagonal(), mean);
}

}  // namespace alidade
