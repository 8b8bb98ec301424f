// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/adjust/board/fit.h"

namespace alidade {

/// Lower bound for solve() on a fit of one radtan camera: a hand-written Gauss-Newton method on the same sums
/// over corners, with poses eliminated per view and steps halved until they lower the cost, without Ceres,
/// options and reasons.
/// @pre the start can be evaluated
/// @returns false if it did not converge
[[nodiscard]] bool solveBlockArrow(Fit& fit);

}  // namespace alidade
