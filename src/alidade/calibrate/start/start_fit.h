// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "alidade/adjust/board/fit.h"
#include "alidade/calibrate/start/calibration_options.h"
#include "alidade/calibrate/start/prepared_views.h"
#include "alidade/calibrate/start/start.h"

namespace alidade {

/// A starting fit, not yet solved for all views.
struct StartedFit {
  Fit fit;                          ///< views that the start explains
  std::vector<PosedCamera> rivals;  ///< see Start; a pose for each prepared view
  StartReport report;
};

/// Finds a camera and poses to start from.
/// @param options  must name a model
/// @throws Error (kInput) if no camera explains the views, or too few of them
[[nodiscard]] StartedFit startedFit(const PreparedViews& given, const CalibratorOptions& options);

/// A fit and the other optima of its start.
struct ComparedFit {
  Fit fit;
  /// Parameters of other optima of about the same cost on all views, for otherOptima().
  std::vector<std::vector<double>> close_params;
};

/// Compares other optima that were about as good on the views of the start; on all views the lowest cost
/// decides.
[[nodiscard]] ComparedFit comparedWithRivals(Fit fit, const std::vector<PosedCamera>& rivals,
                                             const CancelFlag* cancel);

}  // namespace alidade
