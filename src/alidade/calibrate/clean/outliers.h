// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/adjust/noise/robust_weighting.h"
#include "alidade/calibrate/start/prepared_views.h"

namespace alidade {

/// Sets views aside that do not fit the camera of the others, the worst first, and solves again after each:
/// what looks foreign beside a bad view may be right without it. Stops where half of the views are gone: it
/// can then no longer be told which ones are right.
/// @throws Error (kInput) if too few views are left
void setAsideForeignViews(SettledFit& settled, const PreparedViews& given, const CancelFlag* cancel);

/// Takes views back that fit the camera that the others have agreed on without them, and solves again. False
/// if there are none.
bool readmitViews(SettledFit& settled, const PreparedViews& given, const CancelFlag* cancel);

/// Sets views aside of which some corners fit only if all are numbered otherwise; its pose would be wrong
/// as well. False if there are none.
bool setAsideMisnumberedViews(SettledFit& settled, const PreparedViews& given, const CancelFlag* cancel);

/// Leaves out corners that are no noise, and views that do not fit the camera of the others, and solves
/// again. Outliers are judged again in each round, among all corners, until the same ones come out.
/// @throws Error (kInput) if too few views are left
[[nodiscard]] SettledFit withoutOutliers(SettledFit settled, const PreparedViews& given,
                                         const CancelFlag* cancel);

}  // namespace alidade
