// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/adjust/noise/robust_weighting.h"
#include "alidade/calibrate/start/calibration_options.h"
#include "alidade/calibrate/start/reports.h"

namespace alidade {

struct UnevenFit {
  SettledFit settled;
  UnevenReport report;
};

/// Estimates the offsets of the points of all boards (withOffsets()) if requested or, in automatic mode, if
/// they lower the held-out RMS significantly and by more than 5 %: an offset that predicts the corners of
/// other views belongs to the board and not to noise or to a lens beyond its model. A larger lens model that
/// leaves smaller errors takes precedence, and offsets that are mainly a stretch, grading or twist of the
/// whole board are left to the tests for these (CommonError). Boards of more than 400 points are not tested,
/// because the cost of the equations grows with the cube.
/// @param settled  with the bends estimated
[[nodiscard]] UnevenFit uneven(SettledFit settled, BoardShapeMode mode, const CancelFlag* cancel);

/// Estimates the offsets again on the corners now in use.
[[nodiscard]] SettledFit unevenAgain(SettledFit settled, const CancelFlag* cancel);

}  // namespace alidade
