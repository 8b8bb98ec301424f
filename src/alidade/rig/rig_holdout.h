// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/adjust/board/fit.h"
#include "alidade/adjust/noise/cross_validation.h"
#include "alidade/core/cancel.h"

namespace alidade {

/// Cross-validation over frames. Each fold of frames is left out in turn, and cameras and their poses are
/// estimated from the others. Each board of a left-out frame then gets a pose from half of the corners of all
/// cameras that see it, and errors on the other half, and vice versa. Board shapes are not estimated again.
/// num_folds is 0 if the other frames do not determine the rig.
[[nodiscard]] HoldoutReport rigHoldout(const Fit& fit, const CancelFlag* cancel);

}  // namespace alidade
