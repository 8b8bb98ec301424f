// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/adjust/scene/scene_fit.h"

namespace alidade {

/// Minimises the robust reprojection error over poses, points and error fields, with Ceres; the camera is
/// fixed. A sighting that cannot be projected at the start is a failure (Termination::kFailed).
/// @throws Cancelled
[[nodiscard]] SceneFit solveScene(SceneFit fit, const SolveOptions& options = {});

}  // namespace alidade
