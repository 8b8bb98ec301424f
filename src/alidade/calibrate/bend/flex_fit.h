// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/adjust/noise/robust_weighting.h"
#include "alidade/calibrate/start/calibration_options.h"
#include "alidade/core/cancel.h"

namespace alidade {

/// Estimates a bend for each view if requested or, in automatic mode, if the views show that the only board
/// bends differently in each, as paper does that is held by hand, and no larger lens model leaves smaller
/// errors: if bends of single views explain more than 8 times what noise would, and four times what other
/// differences of views beyond them do (focal length, rolling shutter). The bends scatter about the board's
/// own shape with a standard deviation that is estimated with them: by restricted maximum likelihood,
/// iterated with the solve (Harville 1977, Maximum likelihood approaches to variance component estimation and
/// to related problems, Journal of the American Statistical Association 72(358)).
/// @param now  with the board's bend estimated, even
void estimateFlex(SettledFit& now, BoardShapeMode mode, const CancelFlag* cancel);

/// One step: moves the bends of flexible boards in each placement to their optimum with the cameras held, and
/// estimates their scatter. A board without scatter becomes rigid.
/// @returns the largest step in standard deviations of the bend itself; 0 if no board is flexible
[[nodiscard]] double updateFlex(Fit& fit);
inline constexpr double kFlexAtRest = 0.01;  ///< of such steps
inline constexpr int kMostFlexSteps = 100;

/// Estimates the bends again on the corners now in use, if the board still flexes on these.
void estimateFlexAgain(SettledFit& now, BoardShapeMode mode, const CancelFlag* cancel);

}  // namespace alidade
