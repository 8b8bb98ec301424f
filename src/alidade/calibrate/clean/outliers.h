// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/adjust/noise/robust_weighting.h"
#include "alidade/calibrate/start/prepared_views.h"

namespace alidade {

/// Takes back views that fit the camera determined without them, and solves again. False if there are none.
bool readmitViews(SettledFit& settled, const PreparedViews& given, const CancelFlag* cancel);

/// Leaves out corners that are not noise and views that do not fit the camera of the others, and solves
/// again. Each round judges all corners again, until the outliers no longer change.
/// @throws Error (kInput) if too few views are left
[[nodiscard]] SettledFit withoutOutliers(SettledFit settled, const PreparedViews& given,
                                         const CancelFlag* cancel);

/// Everything left out of the fit; each view with its reason if its corners show one.
[[nodiscard]] Dropped droppedFrom(const Fit& fit, const PreparedViews& given, const CancelFlag* cancel);

}  // namespace alidade
