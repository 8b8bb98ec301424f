// SPDX-License-Identifier: MIT
#include "alidade/adjust/board/manifolds.h"

#include <utility>

namespace alidade {
namespace {

using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

}  // namespace

LinearManifold::LinearManifold(Eigen::MatrixXd directions)
    : directions_(std::move(directions)),
      inverse_(directions_.colwise()
                   .squaredNorm()
                   .unaryExpr([](double s) { return s > 0 ? 1 / s : 0.0; })
                   .asDiagonal() *
               directions_.transpose()) {}

bool LinearManifold::Plus(const double* x, const double* delta, double* x_plus_delta) const {
  Eigen::Map<Eigen::VectorXd>(x_plus_delta, AmbientSize()) =
      Eigen::Map<const Eigen::VectorXd>(x, AmbientSize()) +
      directions_ * Eigen::Map<const Eigen::VectorXd>(delta, TangentSize());
  return true;
}

bool LinearManifold::PlusJacobian(const double*, double* jacobian) const {
  Eigen::Map<RowMajorMatrix>(jacobian, AmbientSize(), TangentSize()) = directions_;
  return true;
}

bool LinearManifold::Minus(const double* y, const double* x, double* y_minus_x) const {
  Eigen::Map<Eigen::VectorXd>(y_minus_x, TangentSize()) =
      inverse_ * (Eigen::Map<const Eigen::VectorXd>(y, AmbientSize()) -
                  Eigen::Map<const Eigen::VectorXd>(x, AmbientSize()));
  return true;
}

bool LinearManifold::MinusJacobian(const double*, double* jacobian) const {
  Eigen::Map<RowMajorMatrix>(jacobian, TangentSize(), AmbientSize()) = inverse_;
  return true;
}

}  // namespace alidade
