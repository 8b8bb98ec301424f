// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "alidade/adjust/board/fit.h"
#include "alidade/calibrate/uncertainty/uncertainty.h"
#include "alidade/core/cancel.h"

namespace alidade {

/// An excess cost below this, as a difference of chi square, is attributed to noise: 3 standard deviations
/// for a single question. The likelihood ratio is then less than 90 to 1.
inline constexpr double kNoiseChi2 = 9;

/// Optima left by the search for a start (ModelSolution::close_params) that the corners in use do not rule
/// out although the stated sigmas of the result do. Each is solved to convergence on the same corners with
/// the same loss, board and prior. It counts if it is sound (unsoundnessOf()), its excess cost is below
/// kNoiseChi2, and a parameter differs by more than 3 stated standard deviations. If the board's bend was
/// estimated, it may differ. If the views disagree by more than noise, chi square is scaled by their
/// disagreement.
///
/// Stated sigmas come from the curvature at one optimum and cannot show another.
///
/// @param known  of the same fit, with its covariance; without one the result is empty
[[nodiscard]] std::vector<OtherOptimum> otherOptima(const Fit& fit,
                                                    const std::vector<std::vector<double>>& close_params,
                                                    const Uncertainty& known, const CancelFlag* cancel);

}  // namespace alidade
