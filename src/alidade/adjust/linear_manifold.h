// SPDX-License-Identifier: MIT
#pragma once

#include <ceres/manifold.h>

#include <Eigen/Core>

namespace alidade {

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
