// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/calibrate/estimation.h"

namespace alidade {

/// From views to a camera that fits them, all corners counting by the robust loss alone.
/// @throws Error (kInput) if no camera of the model explains the views
void fitPlainly(Estimation& estimation);

/// Settles what the corners are: the board's bend, outliers, views that do not fit, weights. Holds a lens
/// together that they do not determine.
void settleData(Estimation& estimation);

}  // namespace alidade
