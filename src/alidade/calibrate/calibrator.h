// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "alidade/calibrate/calibration_result.h"
#include "alidade/core/cancel.h"
#include "alidade/target/checkerboard.h"
#include "alidade/target/view.h"

namespace alidade {

struct CalibratorOptions {
  std::string model = "radtan";  ///< an id of the model list
  const CancelFlag* cancel = nullptr;
};

/// Fewest views from which a calibration is attempted. Two would determine four parameters, with nothing left
/// to notice a mistake by.
inline constexpr int kMinViews = 3;

/// Calibrates one camera from views of one board; no initial guess. The views may come in any order and are
/// put in order of their image names first, so that the result does not depend on it. Corners that state
/// different sigmas are weighted, see CornerNoise.
/// @throws Error (kInput): fewer than kMinViews views, views of different image sizes, two views of one
/// image, corner ids that the board does not have, corners that are not finite, negative sigmas, or views
/// that no camera explains. Error (kUsage): unknown model. Cancelled. A poor result is no exception: see
/// CalibrationResult::findings.
[[nodiscard]] CalibrationResult calibrate(const Checkerboard& board, std::vector<View> views,
                                          const CalibratorOptions& options = {});

}  // namespace alidade
