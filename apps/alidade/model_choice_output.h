// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "alidade/adjust/cross_validation.h"
#include "alidade/calibrate/choose/choice.h"

namespace alidade {

/// The table of models for people.
[[nodiscard]] std::string modelChoiceText(const ModelChoice& choice);

[[nodiscard]] nlohmann::json modelChoiceJson(const ModelChoice& choice);

}  // namespace alidade
