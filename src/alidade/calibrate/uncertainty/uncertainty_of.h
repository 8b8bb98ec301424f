// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/calibrate/choose/model_solution.h"
#include "alidade/calibrate/uncertainty/uncertainty.h"

namespace alidade {

/// Of a fit of one camera, solved.
[[nodiscard]] Uncertainty uncertaintyOf(const ModelSolution& solution, const CalibratorOptions& options);

}  // namespace alidade
