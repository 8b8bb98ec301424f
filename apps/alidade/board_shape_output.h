// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "alidade/calibrate/calibration.h"

namespace alidade {

/// What the views say of the board's bend, for the summary: one line or two.
[[nodiscard]] std::string boardShapeText(const Calibration& result);

/// The same in numbers.
[[nodiscard]] nlohmann::json boardShapeJson(const Calibration& result);

}  // namespace alidade
