// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/adjust/board/fit.h"
#include "alidade/core/cancel.h"

namespace alidade {

struct SolveOptions {
  int max_iterations = 500;  ///< a bound on the run time, not a stopping rule: reaching it is a failure
  /// Relative change of the cost at which to stop. The default is tight enough that the digits of the result
  /// do not depend on the initial guess.
  double function_tolerance = 1e-14;
  const CancelFlag* cancel = nullptr;
};

/// Minimises the robust weighted reprojection error over all intrinsics, rig poses, placements and board
/// shapes that are not fixed, with Ceres. Lens parameters stay in their model's ranges; an optimum may be at
/// a limit. Sets the views' errors and the summary.
///
/// The result depends only on the fit, not on the number of processors.
/// @throws Cancelled
[[nodiscard]] Fit solve(Fit fit, const SolveOptions& options = {});

}  // namespace alidade
