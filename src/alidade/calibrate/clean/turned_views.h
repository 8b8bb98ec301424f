// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/adjust/board/fit.h"
#include "alidade/calibrate/start/prepared_views.h"

namespace alidade {

/// Numbers all views of a board alike that looks the same after a turn. A flat board does not tell how it is
/// turned, and one camera need not know; but where the points of a board are off their places, mixed numbers
/// mix the errors of different points, which no bend and no offset explains. The views' errors then agree far
/// better after turns of some views: by the scores of the points' offsets, summed over the views.
/// @param fit    of one camera, from these views
/// @param given  gets the new numbers
/// @returns true if any view was renumbered
[[nodiscard]] bool renumberTurnedViews(const Fit& fit, PreparedViews& given);

}  // namespace alidade
