// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "advice_output.h"
#include "alidade/calibrate/calibration.h"
#include "given_views.h"

namespace alidade {

/// What --verbose adds to the summary.
[[nodiscard]] std::string detailsText(const Calibration& result, const CalibrationInput& input,
                                      const Advice& advice);

/// Everything for programs: one JSON document.
[[nodiscard]] std::string summaryJson(const Calibration& result, const CalibrationInput& input,
                                      const Advice& advice);

}  // namespace alidade
