// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/calibrate/calibration_result.h"
#include "alidade/calibrate/estimation.h"

namespace alidade {

/// What a finished estimation says about camera and views; without findings.
[[nodiscard]] CalibrationResult resultOf(const Estimation& estimation);

}  // namespace alidade
