// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/adjust/board/fit.h"
#include "alidade/core/cancel.h"

namespace alidade {

struct SolveOptions {
  int max_iterations =
      500;  ///< a bound against running for ever, not a stopping rule: reaching it is a failure
  /// Relative change of the cost at which to stop. The default is tight enough that the answer's digits do
  /// not depend on where the iteration started.
  double function_tolerance = 1e-14;
  const CancelFlag* cancel = nullptr;
};

/// Minimises the robust weighted reprojection error over intrinsics, rig poses, placements and board shapes,
/// those that are not fixed, with Ceres. Lens parameters stay in their model's ranges; an optimum may lie on
/// the end of one. Sets the views' errors and the summary.
///
/// The result depends on the fit alone, not on the number of processors.
/// @throws Cancelled
[[nodiscard]] Fit solve(Fit fit, const SolveOptions& options = {});

}  // namespace alidade
