// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/calibrate/estimation.h"

namespace alidade {

/// Finds a camera and poses to start from; views that no pose explains go out of use.
/// @throws Error (kInput) if no camera explains the views, or too few of them
void startEstimation(Estimation& estimation);

/// Other optima that were about as good on the views of the start: on all views the lowest cost decides.
/// Those that stay close are left for otherOptima().
void compareRivals(Estimation& estimation);

}  // namespace alidade
