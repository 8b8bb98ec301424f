// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "alidade/fleet/fleet.h"
#include "alidade/report/data/report_data.h"

namespace alidade {

/// "993 of 1000 units are within 0.5 px of the typical camera: one file may serve for these"; for a group
/// without a typical camera, a sentence that there is none.
[[nodiscard]] std::string servingSentence(const FleetGroup& group, double tolerance_px);

/// The report of a fleet: one self-contained HTML file with findings, figures of each group with a typical
/// camera, and tables of the units that deviate or changed. The data (fleetJson()) are in <script
/// type="application/json" id="evidence">. The output is deterministic.
/// @pre the fleet has a unit
[[nodiscard]] std::string fleetPage(const Fleet& fleet, const RunOrigin& origin);

}  // namespace alidade
