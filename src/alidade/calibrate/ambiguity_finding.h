// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "alidade/calibrate/calibration_result.h"

namespace alidade {

/// Adds `ambiguous_optimum` where another camera of the model explains the corners as well (OtherOptimum),
/// and `model_dependent` where one of another model does and differs over much of the image (ModelSpread).
void judgeAmbiguity(const CalibrationResult& result, std::vector<Finding>& findings);

}  // namespace alidade
