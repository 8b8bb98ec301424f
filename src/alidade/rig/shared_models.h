// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <vector>

#include "alidade/calibrate/calibrator.h"

namespace alidade {

/// The model that each camera of a rig should have. Cameras of one image size and of similar focal lengths
/// are treated as equal: among the models chosen for them, they share the one that was tried in most of them,
/// with the lowest held-out error in sum. A camera keeps its own model where its gain is clear, or where the
/// user named it. Where the shared one was not tried, the caller compares.
[[nodiscard]] std::vector<std::string> sharedModels(std::span<const Calibration> alone);

}  // namespace alidade
