// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/calibrate/estimation.h"

namespace alidade {

/// Leaves out corners that are no noise, and views that do not fit the camera of the others, and solves
/// again. Outliers are judged anew in each round, among all corners, until the same ones come out.
void leaveOutOutliers(Estimation& estimation);

}  // namespace alidade
