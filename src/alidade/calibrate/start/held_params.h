// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "alidade/adjust/board/fit.h"
#include "alidade/calibrate/start/calibration_options.h"

namespace alidade {

/// The model that the options name; that of the initial camera where they leave it open and give one. Still
/// kAutoModel where it is to be chosen.
[[nodiscard]] std::string namedModel(const CalibratorOptions& options);

/// The constraint that the options name. Where the model is to be chosen, only parameters that all models
/// have can be held.
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
