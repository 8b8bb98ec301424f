// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "alidade/calibrate/calibration_result.h"

namespace alidade {

/// Adds `ambiguous_optimum` where another camera explains the corners as well (OtherOptimum).
void judgeAmbiguity(const CalibrationResult& result, std::vector<Finding>& findings);

}  // namespace alidade
