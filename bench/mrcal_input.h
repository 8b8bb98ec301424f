// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/adjust/board/fit.h"

namespace alidade {

/// Has mrcal_solve.py solve a fit from its start and print what it reports.
/// @param fit  of radtan cameras of one image size, the first one at the rig's origin, and one checkerboard
/// @returns whether the script ran
[[nodiscard]] bool solveByMrcal(const Fit& fit, int num_repetitions);

}  // namespace alidade
