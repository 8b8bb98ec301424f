// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <vector>

#include "alidade/calibrate/calibrator.h"

namespace alidade {

/// The model that each camera of a rig should have. Cameras of one image size and of similar focal lengths
/// are treated as equal: among the models chosen for them, they share the one with the lowest held-out error
/// in sum. A camera keeps its own model where its gain is clear, where the shared one was not tried, or where
/// the user named it.
[[nodiscard]] std::vector<std::string> sharedModels(std::span<const Calibration> alone);

}  // namespace alidade
