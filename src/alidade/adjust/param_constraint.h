// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

namespace alidade {

/// The intrinsics that a solve must not change.
struct ParamConstraint {
  std::vector<int> held = {};  ///< indices of fixed parameters
  bool same_focal = false;     ///< fx and fy move by the same step; equal at the start, they stay equal

  [[nodiscard]] bool isNone() const { return held.empty() && !same_focal; }
};

/// The directions that are left, one a column: N parameters x M.
[[nodiscard]] Eigen::MatrixXd freeDirections(int num_params, const ParamConstraint& constraint);

}  // namespace alidade
