// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "advice_output.h"
#include "alidade/calibrate/calibration.h"
#include "given_views.h"

namespace alidade {

/// The summary for people.
[[nodiscard]] std::string summaryText(const Calibration& result, const CalibrationInput& input,
                                      const Advice& advice);

/// The same for programs: one JSON document.
[[nodiscard]] std::string summaryJson(const Calibration& result, const CalibrationInput& input,
                                      const Advice& advice);

}  // namespace alidade
