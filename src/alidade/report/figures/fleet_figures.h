// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/fleet/fleet.h"
#include "alidade/report/canvas/figure_canvas.h"

namespace alidade {

// Figures of a group of a fleet. @pre the group has a typical camera, and units that can be compared with it

/// The distance from the typical camera that 95 % of the units keep, over the image.
[[nodiscard]] Figure fleetMapFigure(const FleetGroup& group, double tolerance_px);
/// How many units are at which distance from the typical camera. Bars carry their count as data-count.
[[nodiscard]] Figure fleetDistancesFigure(const FleetGroup& group, double tolerance_px);
/// The parameters of the units about those of the typical camera, in standard deviations between units.
[[nodiscard]] Figure fleetParametersFigure(const Fleet& fleet, const FleetGroup& group);
/// Differences of the units of the fleet from their previous calibrations. @pre there are some that can
/// be compared
[[nodiscard]] Figure fleetDriftFigure(const Fleet& fleet);

}  // namespace alidade
