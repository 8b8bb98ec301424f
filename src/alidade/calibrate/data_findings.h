// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "alidade/calibrate/calibration_result.h"

namespace alidade {

/// Adds what is wrong with corners, views and the board.
void judgeData(const CalibrationResult& result, std::vector<Finding>& findings);

}  // namespace alidade
