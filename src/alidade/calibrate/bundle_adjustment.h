// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "alidade/calibrate/lens_prior.h"
#include "alidade/calibrate/observation.h"
#include "alidade/calibrate/param_constraint.h"
#include "alidade/core/cancel.h"
#include "alidade/geometry/se3.h"

namespace alidade {

/// What the solver works on and leaves its answer in.
struct BundleState {
  std::vector<double> params;          ///< fx fy cx cy, then the lens
  std::vector<SE3> camera_from_board;  ///< one a view
};

struct BundleOptions {
  HuberLoss loss{.threshold_px = 1.0};
  int max_iterations =
      500;  ///< a bound against running for ever, not a stopping rule: reaching it is a failure
  /// Relative change of the cost at which to stop. The default is tight enough that the answer's digits do
  /// not depend on where the iteration started.
  double function_tolerance = 1e-14;
  ParamConstraint constraint = {};
  LensPrior prior = {};
  const CancelFlag* cancel = nullptr;
};

enum class Termination {
  kConverged,
  kIterationLimit,
  kStalled,  ///< no step lowers the cost any more, far from a stationary point
  kFailed,   ///< the start cannot be evaluated or the linear algebra broke down
};

/// Stable name for files and JSON.
[[nodiscard]] std::string_view terminationName(Termination termination);

struct BundleSummary {
  Termination termination = Termination::kFailed;
  std::string reason;         ///< the solver's own words
  int num_iterations = 0;     ///< steps tried
  std::vector<int> at_limit;  ///< parameters that the optimum pushes against the end of their range
  /// Half the sum of rho over all corners, px^2 of a corner of weight 1, with the prior's share; NaN where
  /// the start has none.
  double cost = 0;
};

/// Minimises the robust weighted reprojection error over intrinsics and poses with Ceres, which sees the
/// poses eliminated (BundleProblem). Ends, too, where the next step would change the cost by less than
/// `function_tolerance`. Lens parameters stay in their model's ranges; an optimum may lie on the end of
/// one.
/// @param views  the corners of each view; as many as state.camera_from_board
[[nodiscard]] BundleSummary solveBundle(std::string_view model_id,
                                        std::span<const std::vector<Observation>> views, BundleState& state,
                                        const BundleOptions& options);

/// Errors (projected minus observed, px, not weighted) of all corners of a view; NaN where a corner cannot be
/// projected.
[[nodiscard]] std::vector<Eigen::Vector2d> reprojectionErrors(std::string_view model_id,
                                                              std::span<const double> params,
                                                              const SE3& camera_from_board,
                                                              std::span<const Observation> view);

}  // namespace alidade
