// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/detect/edge_kernel.h"
#include "alidade/detect/edge_model.h"

namespace alidade {

/// What is known of a model's parameters apart from the pixels, as terms precision * (value - expected)^2
/// next to the sum of squared residuals; precisions are in squared grey levels over the parameter's unit
/// squared.
struct EdgePrior {
  static constexpr double kHeld = 1e12;  ///< a precision that keeps a parameter where it is expected

  EdgeModel expected;
  EdgeModel precision;
  double equal_blur = 0;     ///< precision of the difference of the two blurs
  bool common_blur = false;  ///< both lines have the first one's blur
};

struct EdgeSolverOptions {
  /// Sharper than this, edges pass between the pixels' centres and the cost has steps. The pixel's own width
  /// alone has a standard deviation of 0.29; sharpened images can show less.
  double min_blur_px = 0.4;
  double max_blur_px = 1e3;
  int max_iterations = 20;
  /// Ends when the next step is expected to be shorter than this share of the estimate's standard deviation.
  double step_share = 0.1;
};

struct EdgeSolution {
  EdgeModel model;
  NormalEquations sums;  ///< at the model
  bool converged = false;
  int num_evaluations = 0;
};

/// Least squares from `start` by damped Gauss-Newton steps (Levenberg 1944, Marquardt 1963).
[[nodiscard]] EdgeSolution solveEdgeModel(const EdgePixels& pixels, const EdgeModel& start,
                                          const EdgePrior& prior, const EdgeSolverOptions& options);

}  // namespace alidade
