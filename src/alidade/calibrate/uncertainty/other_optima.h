// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "alidade/adjust/board/fit.h"
#include "alidade/calibrate/uncertainty/uncertainty.h"
#include "alidade/core/cancel.h"

namespace alidade {

/// A cost above that of the result by less than this, as a difference of chi square, is what noise makes: 3
/// standard deviations of a single question. The likelihoods of the two are then less than 90 to 1.
inline constexpr double kNoiseChi2 = 9;

/// Of the optima that a search for a start has left (ComparedFit::close_params), those that the corners in
/// use do not rule out and that the stated sigmas of the result do: each is solved to rest on the same
/// corners with the same loss, board and prior, and counts if it is sound (unsoundnessOf()), costs more by
/// less than kNoiseChi2 and has a parameter beyond 3 stated standard deviations. Where the board's bend was
/// estimated, it may differ. Where the views disagree by more than noise, the chi square is by
/// their disagreement.
///
/// Local sigmas come from the curvature at one optimum and cannot know of another.
///
/// @param known  of the same fit, with its covariance; without one there are no sigmas to contradict
[[nodiscard]] std::vector<OtherOptimum> otherOptima(const Fit& fit,
                                                    const std::vector<std::vector<double>>& close_params,
                                                    const Uncertainty& known, const CancelFlag* cancel);

}  // namespace alidade
