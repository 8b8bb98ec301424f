// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/calibrate/calibrator.h"
#include "alidade/calibrate/param_constraint.h"

namespace alidade {

/// The constraint that the options name.
/// @throws Error (kUsage) for a name that the model does not have, or a parameter that needs an initial
/// camera to have a value
[[nodiscard]] ParamConstraint constraintOf(const CalibratorOptions& options);

/// Parameters of the model that is asked for from the initial camera.
/// @throws Error (kInput) if it is of another image size
[[nodiscard]] std::vector<double> initialParameters(const CalibratorOptions& options, ImageSize size);

/// Gives held parameters their values where no initial camera did, and makes focal lengths equal if they are
/// to be. False if nothing changed.
bool applyConstraint(const CalibratorOptions& options, const ParamConstraint& constraint, ImageSize size,
                     std::vector<double>& params);

}  // namespace alidade
