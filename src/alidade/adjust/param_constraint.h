// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

namespace alidade {

/// The intrinsics that a solve must not change.
struct ParamConstraint {
  std::vector<int> held = {};  ///< indices of fixed parameters
  bool same_focal = false;     ///< fx and fy change by the same step, so they stay equal

  [[nodiscard]] bool isNone() const { return held.empty() && !same_focal; }
};

/// The remaining free directions, one per column: N parameters x M.
[[nodiscard]] Eigen::MatrixXd freeDirections(int num_params, const ParamConstraint& constraint);

}  // namespace alidade
