// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/adjust/board/fit.h"

namespace alidade {

/// Makes mrcal_solve.py solve a fit from its start and prints its report.
/// @param fit  of radtan cameras of one image size, the first one at the rig's origin, and one checkerboard
/// @returns true if the script ran
[[nodiscard]] bool solveByMrcal(const Fit& fit, int num_repetitions);

}  // namespace alidade
