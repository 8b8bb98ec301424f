// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "alidade/calibrate/bundle_adjustment.h"
#include "alidade/target/checkerboard.h"

namespace alidade {

/// What one view says, its pose following: the Schur complement of the pose in the view's normal equations.
struct ViewPull {
  Eigen::MatrixXd information;  ///< J^T W J, per px^2
  Eigen::VectorXd gradient;     ///< J^T W psi, psi being the error less what the loss takes off it
};

/// Of the intrinsics, one a view. The information is that of a fit without a loss.
[[nodiscard]] std::vector<ViewPull> viewPulls(std::string_view model_id,
                                              std::span<const std::vector<Observation>> views,
                                              const BundleState& state, HuberLoss loss);

enum class LossWeights {
  kLeaveOut,  ///< the information is that of a fit without a loss
  kUse,       ///< it is that of iteratively reweighted least squares
};

/// Number of columns behind the intrinsics' that stand for BoardShape.
inline constexpr int kNumBends = 2;

/// Of the intrinsics and, behind them, bend_x and bend_y of the board's shape, one a view.
[[nodiscard]] std::vector<ViewPull> viewPullsWithBend(std::string_view model_id, const Checkerboard& board,
                                                      std::span<const std::vector<Observation>> views,
                                                      const BundleState& state, HuberLoss loss,
                                                      LossWeights weights);

}  // namespace alidade
