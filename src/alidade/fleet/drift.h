// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "alidade/fleet/fleet_unit.h"

namespace alidade {

/// For each unit the index of the previous unit that is the same camera: with the same serial number, else
/// the same name, else the same place in its folder, else the same file name. A key that occurs twice on one
/// side pairs nothing, and neither do different serial numbers. No previous unit is paired twice.
[[nodiscard]] std::vector<std::optional<std::size_t>> pairedUnits(std::span<const FleetUnit> units,
                                                                  std::span<const FleetUnit> previous);

}  // namespace alidade
