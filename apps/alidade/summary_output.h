// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

#include "advice_output.h"
#include "alidade/calibrate/calibration.h"
#include "given_views.h"

namespace alidade {

struct SummaryStyle {
  double tolerance_px = 1;
  bool is_coloured = false;  ///< for a terminal
};

/// The summary of a calibration for people: at most 16 lines of at most 100 columns, the verdict and the
/// accuracy first.
[[nodiscard]] std::string summaryText(const Calibration& result, const CalibrationInput& input,
                                      const Advice& advice, const SummaryStyle& style);

/// The accuracy over the image; null without a covariance.
[[nodiscard]] nlohmann::json accuracyJson(const Calibration& result);

/// "Warning", "FAILED" or "Note".
[[nodiscard]] std::string_view severityLabel(Severity severity);

}  // namespace alidade
