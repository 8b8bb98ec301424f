// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "alidade/adjust/fit.h"
#include "alidade/core/cancel.h"
#include "alidade/rig/rig_calibration.h"

namespace alidade {

/// Compares a fit whose lens was kept with the same one freed.
/// @param fit  of one camera, all of its parameters held
/// @returns nothing if the freed fit is no better beyond chance, or has no solution
[[nodiscard]] std::optional<LensMisfit> givenLensMisfit(const Fit& fit, const CancelFlag* cancel);

}  // namespace alidade
