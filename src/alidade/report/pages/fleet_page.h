// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "alidade/fleet/fleet.h"

namespace alidade {

/// "993 of 1000 units are within 0.5 px of the typical camera: one file may serve for these"; of a group
/// without a typical camera, that there is none.
[[nodiscard]] std::string servingSentence(const FleetGroup& group, double tolerance_px);

/// The report of a fleet: one HTML file that needs nothing else, with what was found, figures of each group
/// with a typical camera, and tables of the units that deviate or changed. The data (fleetJson()) are in
/// <script type="application/json" id="evidence">. The same fleet gives the same bytes.
/// @pre the fleet has a unit
[[nodiscard]] std::string fleetPage(const Fleet& fleet, const std::string& created_by);

}  // namespace alidade
