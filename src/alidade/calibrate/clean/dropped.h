// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/adjust/board/fit.h"
#include "alidade/calibrate/start/prepared_views.h"
#include "alidade/calibrate/start/reports.h"
#include "alidade/core/cancel.h"

namespace alidade {

/// Everything left out of the fit; each view with its reason if its corners show one.
[[nodiscard]] Dropped droppedFrom(const Fit& fit, const PreparedViews& given, const CancelFlag* cancel);

}  // namespace alidade
