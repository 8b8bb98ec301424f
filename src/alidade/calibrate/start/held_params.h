// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "alidade/adjust/board/fit.h"
#include "alidade/calibrate/start/calibration_options.h"

namespace alidade {

/// The model named in the options, else that of the initial camera. Still kAutoModel if it is to be chosen.
[[nodiscard]] std::string namedModel(const CalibratorOptions& options);

/// The constraint named in the options, and the parameter that is redundant (CameraModel::kRedundant). If the
/// model is to be chosen, only parameters common to all models can be held.
/// @throws Error (kUsage) for a name that the model does not have, or a parameter that needs an initial
/// camera to have a value
[[nodiscard]] ParamConstraint constraintOf(const CalibratorOptions& options);

/// Parameters of the requested model from the initial camera.
/// @throws Error (kInput) if its image size differs
[[nodiscard]] std::vector<double> initialParameters(const CalibratorOptions& options, ImageSize size);

/// Sets held parameters that no initial camera determines, and makes focal lengths equal if requested. False
/// if nothing changed.
bool applyConstraint(const CalibratorOptions& options, const ParamConstraint& constraint, ImageSize size,
                     std::vector<double>& params);

}  // namespace alidade
