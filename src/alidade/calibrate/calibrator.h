// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "alidade/calibrate/calibration.h"
#include "alidade/calibrate/start/options.h"
#include "alidade/target/checkerboard.h"
#include "alidade/target/view.h"

namespace alidade {

/// Calibrates one camera from views of one board; no initial guess. The views may come in any order and are
/// put in order of their image names first, so that the result does not depend on it. Corners that state
/// different sigmas are weighted, see CornerNoise.
/// @throws Error (kInput): fewer than kMinViews views, views of different image sizes, two views of one
/// image, corner ids that the board does not have, corners that are not finite, negative sigmas, or views
/// that no camera explains, an initial camera of another image size. Error (kUsage): unknown model or
/// parameter to hold, or one that has no value to be held at. Cancelled. A poor result is no exception: see
/// Calibration::diagnoses.
[[nodiscard]] Calibration calibrate(const Checkerboard& board, std::vector<View> views,
                                    const CalibratorOptions& options = {});

}  // namespace alidade
