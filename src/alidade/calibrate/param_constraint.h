// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <ceres/manifold.h>
#include <Eigen/Core>

namespace alidade {

/// What a solve must leave alone among the intrinsics.
struct ParamConstraint {
  std::vector<int> held = {};  ///< indices of parameters that stay as they are
  bool same_focal = false;     ///< fx and fy move by the same step; equal at the start, they stay equal

  [[nodiscard]] bool isNone() const { return held.empty() && !same_focal; }
};

/// The directions that are left, one a column: N parameters x M.
[[nodiscard]] Eigen::MatrixXd freeDirections(int num_params, const ParamConstraint& constraint);

/// The plane through a point along given directions (orthogonal columns), for Ceres.
class LinearManifold final : public ceres::Manifold {
 public:
  explicit LinearManifold(Eigen::MatrixXd directions);
  [[nodiscard]] int AmbientSize() const override { return static_cast<int>(directions_.rows()); }
  [[nodiscard]] int TangentSize() const override { return static_cast<int>(directions_.cols()); }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;

 private:
  Eigen::MatrixXd directions_;
  Eigen::MatrixXd inverse_;  // M x N
};

}  // namespace alidade
