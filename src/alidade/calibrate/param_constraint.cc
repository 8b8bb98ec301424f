// SPDX-License-Identifier: MIT
#include "alidade/calibrate/param_constraint.h"

#include <algorithm>
#include <utility>

namespace alidade {
namespace {

using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

}  // namespace

Eigen::MatrixXd freeDirections(int num_params, const ParamConstraint& constraint) {
  const auto isHeld = [&](int i) {
    return std::find(constraint.held.begin(), constraint.held.end(), i) != constraint.held.end();
  };
  std::vector<Eigen::VectorXd> columns;
  int next = 0;
  if (constraint.same_focal) {
    next = 2;
    if (!isHeld(0) && !isHeld(1))
      columns.emplace_back(Eigen::VectorXd::Unit(num_params, 0) + Eigen::VectorXd::Unit(num_params, 1));
  }
  for (int i = next; i < num_params; ++i) {
    if (!isHeld(i)) columns.emplace_back(Eigen::VectorXd::Unit(num_params, i));
  }
  Eigen::MatrixXd directions(num_params, static_cast<Eigen::Index>(columns.size()));
  for (std::size_t i = 0; i < columns.size(); ++i) directions.col(static_cast<Eigen::Index>(i)) = columns[i];
  return directions;
}

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
