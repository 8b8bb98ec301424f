// SPDX-License-Identifier: MIT
#include "alidade/adjust/board/manifolds.h"

#include <algorithm>

namespace alidade {
namespace {

// d(q Exp(w)) / dw at w = 0 is half the matrix of x -> q x on imaginary x: rows qx, qy, qz, qw.
Eigen::Matrix<double, 4, 3> halfQuaternionProduct(const Eigen::Quaterniond& q) {
  Eigen::Matrix<double, 4, 3> m;
  m << q.w(), -q.z(), q.y(),  //
      q.z(), q.w(), -q.x(),   //
      -q.y(), q.x(), q.w(),   //
      -q.x(), -q.y(), -q.z();
  return 0.5 * m;
}

}  // namespace

bool SE3Manifold::Plus(const double* x, const double* delta, double* x_plus_delta) const {
  const SE3 moved = fromBlock(x) * SE3::exp(Eigen::Map<const SE3::Vec6>(delta));
  const PoseBlock block = toBlock(moved);
  std::copy(block.begin(), block.end(), x_plus_delta);
  return true;
}

bool SE3Manifold::PlusJacobian(const double* x, double* jacobian) const {
  const SE3 pose = fromBlock(x);
  Eigen::Map<Eigen::Matrix<double, 7, 6, Eigen::RowMajor>> J(jacobian);
  J.setZero();
  J.topRightCorner<4, 3>() = halfQuaternionProduct(pose.rotation.quaternion());
  J.bottomLeftCorner<3, 3>() = pose.rotation.matrix();
  return true;
}

bool SE3Manifold::Minus(const double* y, const double* x, double* y_minus_x) const {
  Eigen::Map<SE3::Vec6> difference(y_minus_x);
  difference = (fromBlock(x).inverse() * fromBlock(y)).log();
  return true;
}

bool SE3Manifold::MinusJacobian(const double* x, double* jacobian) const {
  const SE3 pose = fromBlock(x);
  Eigen::Map<Eigen::Matrix<double, 6, 7, Eigen::RowMajor>> J(jacobian);
  J.setZero();
  // The pseudo-inverse of PlusJacobian, whose quaternion columns are orthogonal with length 1/2.
  J.bottomLeftCorner<3, 4>() = 4 * halfQuaternionProduct(pose.rotation.quaternion()).transpose();
  J.topRightCorner<3, 3>() = pose.rotation.matrix().transpose();
  return true;
}

}  // namespace alidade
