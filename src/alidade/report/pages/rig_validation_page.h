// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "alidade/report/data/report_data.h"
#include "alidade/rig/rig_validation.h"

namespace alidade {

/// "The images confirm the rig", with or without reservations, or "... contradict the rig".
[[nodiscard]] std::string rigHeadline(Verdict verdict);

/// The page of `alidade rig validate`. @param file  of the rig; @param document  that of --json
[[nodiscard]] std::string rigValidationPage(const std::string& file, const RigValidation& tested,
                                            const RunOrigin& origin, const nlohmann::json& document);

}  // namespace alidade
