// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/adjust/noise/robust_weighting.h"
#include "alidade/calibrate/start/prepared_views.h"

namespace alidade {

/// Sets aside views that do not fit the camera of the others, the worst first, and solves again after each:
/// views that look wrong beside a bad one may be right without it. Stops when half of the views are gone,
/// since it is then unclear which are right.
/// @throws Error (kInput) if too few views are left
void setAsideForeignViews(SettledFit& settled, const PreparedViews& given, const CancelFlag* cancel);

/// Takes back views that fit the camera determined without them, and solves again. False if there are none.
bool readmitViews(SettledFit& settled, const PreparedViews& given, const CancelFlag* cancel);

/// Sets aside views of which some corners fit only if all are numbered differently; the pose would be wrong
/// as well. False if there are none.
bool setAsideMisnumberedViews(SettledFit& settled, const PreparedViews& given, const CancelFlag* cancel);

/// Leaves out corners that are not noise and views that do not fit the camera of the others, and solves
/// again. Each round judges all corners again, until the outliers no longer change.
/// @throws Error (kInput) if too few views are left
[[nodiscard]] SettledFit withoutOutliers(SettledFit settled, const PreparedViews& given,
                                         const CancelFlag* cancel);

}  // namespace alidade
