// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "alidade/calibrate/calibration_result.h"

namespace alidade {

/// The parameters with their sigmas, and what these mean in the image, for the summary.
[[nodiscard]] std::string parameterTable(const CalibrationResult& result);
[[nodiscard]] std::string projectionText(const CalibrationResult& result);

/// Adds parameters, sigmas, covariance and projection uncertainty to the document.
void addUncertainty(const CalibrationResult& result, nlohmann::json& document);

}  // namespace alidade
