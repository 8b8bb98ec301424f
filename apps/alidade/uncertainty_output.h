// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "alidade/calibrate/calibration_result.h"
#include "alidade/files/camera_file.h"

namespace alidade {

/// The parameters with their sigmas, and what these mean in the image, for the summary.
[[nodiscard]] std::string parameterTable(const CalibrationResult& result);
[[nodiscard]] std::string projectionText(const CalibrationResult& result);

/// Adds parameters, sigmas, covariance and projection uncertainty to the document.
void addUncertainty(const CalibrationResult& result, nlohmann::json& document);

/// Sets sigmas, covariance and projection uncertainty of the record.
void recordUncertainty(const CalibrationResult& result, CalibrationRecord& record);

}  // namespace alidade
