// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/adjust/board/fit.h"
#include "alidade/calibrate/uncertainty/uncertainty.h"

namespace alidade {

/// @param fit  of one camera, solved
[[nodiscard]] ViewVariations viewVariations(const Fit& fit);

}  // namespace alidade
