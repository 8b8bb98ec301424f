// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/adjust/board/fit.h"

namespace alidade {

/// The floor of solve() for a fit of one radtan camera: Gauss and Newton's method by hand on the same sums
/// over corners, poses eliminated by view, steps halved until they lower the cost, without Ceres. Nothing
/// else: no options, no reasons, and it takes for granted that the start can be evaluated.
/// @returns false if it has not come to rest
[[nodiscard]] bool solveBlockArrow(Fit& fit);

}  // namespace alidade
