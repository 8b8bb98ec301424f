// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "alidade/core/diagnosis.h"
#include "alidade/fleet/fleet.h"

namespace alidade {

/// Diagnoses of a fleet, the most severe first: units that deviate or have drifted, files that cannot be
/// read, groups that do not form a population.
[[nodiscard]] std::vector<Diagnosis> fleetFindings(const Fleet& fleet);

/// The units of a group that deviate, the largest difference first; indices into FleetGroup::units.
[[nodiscard]] std::vector<std::size_t> deviatingUnits(const FleetGroup& group);
/// The drifts that are significant, the largest first; indices into Fleet::drifts.
[[nodiscard]] std::vector<std::size_t> driftedUnits(const Fleet& fleet);

/// One CSV record per unit, with a header: values from its file, its difference from the typical camera and
/// from its previous calibration. Unknown fields are empty.
[[nodiscard]] std::string fleetCsv(const Fleet& fleet);

}  // namespace alidade
