// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/calibrate/choose/model_solution.h"
#include "alidade/calibrate/uncertainty/uncertainty.h"

namespace alidade {

/// The uncertainty of a solved fit of one camera.
[[nodiscard]] Uncertainty uncertaintyOf(const ModelSolution& solution, const CalibratorOptions& options);

/// Projects the stated covariance anew. @pre there is one
void setProjected(const Fit& fit, Uncertainty& known);

}  // namespace alidade
