// SPDX-License-Identifier: MIT
#include "alidade/adjust/param_constraint.h"

#include <algorithm>

namespace alidade {

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

}  // namespace alidade
