// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/calibrate/calibration_result.h"
#include "alidade/calibrate/choose/model_solution.h"

namespace alidade {

/// What a solution says about camera and views; without findings.
[[nodiscard]] CalibrationResult resultOf(const ModelSolution& solution, const PreparedViews& given,
                                         const CalibratorOptions& options);

}  // namespace alidade
