// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/adjust/robust_weighting.h"
#include "alidade/calibrate/start/prepared_views.h"

namespace alidade {

/// Leaves out corners that are no noise, and views that do not fit the camera of the others, and solves
/// again. Outliers are judged anew in each round, among all corners, until the same ones come out.
/// @throws Error (kInput) if too few views are left
[[nodiscard]] SettledFit withoutOutliers(SettledFit settled, const PreparedViews& given,
                                         const CancelFlag* cancel);

}  // namespace alidade
