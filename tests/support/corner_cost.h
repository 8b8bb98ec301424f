// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <span>
#include <vector>

#include <ceres/autodiff_cost_function.h>
#include <ceres/loss_function.h>
#include <ceres/problem.h>

#include "alidade/adjust/board/manifolds.h"
#include "alidade/adjust/board/observation.h"
#include "support/project_formula.h"

namespace alidade {

/// One corner, differentiated automatically: with Ceres' own loss, the plainest form of a bundle adjustment.
template <class M>
struct CornerCost {
  Observation observation;

  template <class T>
  bool operator()(const T* params, const T* pose, T* residual) const {
    const Eigen::Quaternion<T> q(pose[3], pose[0], pose[1], pose[2]);
    const Eigen::Matrix<T, 3, 1> t(pose[4], pose[5], pose[6]);
    const Eigen::Matrix<T, 3, 1> p = q * observation.p_board.cast<T>() + t;
    T px[2];
    if (!projectFormula<M>(params, p.data(), px)) return false;
    const double root = std::sqrt(observation.weight);
    residual[0] = root * (px[0] - observation.pixel.x());
    residual[1] = root * (px[1] - observation.pixel.y());
    return true;
  }
};

/// Adds a residual block a corner. The problem takes the loss, which may be null for none.
template <class M>
void addCorners(ceres::Problem& problem, std::span<const std::vector<Observation>> views,
                ceres::LossFunction* loss, std::vector<double>& params, std::vector<PoseBlock>& poses) {
  for (std::size_t v = 0; v < views.size(); ++v) {
    for (const Observation& observation : views[v]) {
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<CornerCost<M>, 2, kNumParams<M>, 7>(new CornerCost<M>{observation}),
          loss, params.data(), poses[v].data());
    }
    problem.SetManifold(poses[v].data(), new SE3Manifold);
  }
}

}  // namespace alidade
