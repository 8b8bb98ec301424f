// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/fleet/fleet.h"
#include "alidade/report/canvas/figure_canvas.h"

namespace alidade {

// Figures of a group of a fleet. @pre the group has a typical cameraand units comparable with it

/// The distance from the typical camera that 95 % of the units do not exceed, over the image.
[[nodiscard]] Figure fleetMapFigure(const FleetGroup& group, double tolerance_px);
/// Histogram of the units' distances from the typical camera. Bars carry their count as data-count.
[[nodiscard]] Figure fleetDistancesFigure(const FleetGroup& group, double tolerance_px);
/// The parameters of the units relative to the typical camera, in standard deviations between units.
[[nodiscard]] Figure fleetParametersFigure(const Fleet& fleet, const FleetGroup& group);
/// Differences of the units of the fleet from their previous calibrations. @pre some are comparable
[[nodiscard]] Figure fleetDriftFigure(const Fleet& fleet);

}  // namespace alidade
