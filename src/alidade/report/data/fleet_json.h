// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "alidade/fleet/fleet.h"

namespace alidade {

/// All results on a fleet, as data: groups with their typical cameras, units, unreadable files.
[[nodiscard]] nlohmann::json fleetJson(const Fleet& fleet, const std::string& created_by);

}  // namespace alidade
