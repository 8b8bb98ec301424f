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

/// Estimates the offsets of the boards' points (withOffsets()), of all boards, if asked to, or if that is
/// left open and they lower the held-out RMS significantly, by more than 5 %: an offset that corners of other
/// views predict is the board's, whatever noise or a lens beyond its model make of it. A larger lens model
/// that leaves smaller errors goes first, and offsets that are mostly a stretch, a grading or a twist of the
/// board as a whole are left to the tests of these (CommonError). Boards of more than 400 points are not
/// tested: the equations grow with the cube.
/// @param settled  with the bends estimated
[[nodiscard]] UnevenFit uneven(SettledFit settled, BoardShapeMode mode, const CancelFlag* cancel);

/// On the corners now in use.
[[nodiscard]] SettledFit unevenAgain(SettledFit settled, const CancelFlag* cancel);

}  // namespace alidade
