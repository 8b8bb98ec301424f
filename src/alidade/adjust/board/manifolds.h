// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
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

// d(q Exp(w)) / dw at w = 0 is half the matrix of x -> q x on imaginary x: rows qx, qy, qz, qw.
inline Eigen::Matrix<double, 4, 3> halfQuaternionProduct(const Eigen::Quaterniond& q) {
  Eigen::Matrix<double, 4, 3> m;
  m << q.w(), -q.z(), q.y(),  //
      q.z(), q.w(), -q.x(),   //
      -q.y(), q.x(), q.w(),   //
      -q.x(), -q.y(), -q.z();
  return 0.5 * m;
}

/// SE(3) for Ceres with this project's tangent: T Exp(xi), xi = [translation, rotation] in metres and true
/// radians (Ceres' own quaternion manifolds use half angles, which would make every rotation variance a
/// quarter).
class SE3Manifold final : public ceres::Manifold {
 public:
  [[nodiscard]] int AmbientSize() const override { return 7; }
  [[nodiscard]] int TangentSize() const override { return 6; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override {
    const SE3 moved = fromBlock(x) * SE3::exp(Eigen::Map<const SE3::Vec6>(delta));
    const PoseBlock block = toBlock(moved);
    std::copy(block.begin(), block.end(), x_plus_delta);
    return true;
  }
  bool PlusJacobian(const double* x, double* jacobian) const override {
    const SE3 pose = fromBlock(x);
    Eigen::Map<Eigen::Matrix<double, 7, 6, Eigen::RowMajor>> J(jacobian);
    J.setZero();
    J.topRightCorner<4, 3>() = halfQuaternionProduct(pose.rotation.quaternion());
    J.bottomLeftCorner<3, 3>() = pose.rotation.matrix();
    return true;
  }
  bool Minus(const double* y, const double* x, double* y_minus_x) const override {
    Eigen::Map<SE3::Vec6> difference(y_minus_x);
    difference = (fromBlock(x).inverse() * fromBlock(y)).log();
    return true;
  }
  bool MinusJacobian(const double* x, double* jacobian) const override {
    const SE3 pose = fromBlock(x);
    Eigen::Map<Eigen::Matrix<double, 6, 7, Eigen::RowMajor>> J(jacobian);
    J.setZero();
    // The pseudo-inverse of PlusJacobian, whose quaternion columns are orthogonal with length 1/2.
    J.bottomLeftCorner<3, 4>() = 4 * halfQuaternionProduct(pose.rotation.quaternion()).transpose();
    J.topRightCorner<3, 3>() = pose.rotation.matrix().transpose();
    return true;
  }
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
