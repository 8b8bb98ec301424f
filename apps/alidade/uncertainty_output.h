// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "alidade/calibrate/calibration.h"

namespace alidade {

[[nodiscard]] std::string projectionText(const Calibration& result);

/// Adds parameters, sigmas, covariance and projection uncertainty to the document.
void addUncertainty(const Calibration& result, nlohmann::json& document);

}  // namespace alidade
