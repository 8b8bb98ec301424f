// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "alidade/calibrate/start/calibration_options.h"
#include "alidade/calibrate/start/prepared_views.h"
#include "alidade/calibrate/start/reports.h"
#include "alidade/camera/any_camera.h"

namespace alidade {

/// A camera of one model that fits the views, and how it was found.
struct ModelSolution {
  Fit fit;
  Choice choice;  ///< except what concerns other models
  /// Parameters of other optima that were about as good on all views, for otherOptima().
  std::vector<std::vector<double>> close_params;
  std::vector<AnyCamera> rivals = {};  ///< other models that predict the corners equally well
};

/// Fits a camera to the views; all corners count by the robust loss alone.
/// @param options  must name a model
/// @throws Error (kInput) if no camera of the model explains the views
[[nodiscard]] ModelSolution fittedPlainly(const PreparedViews& given, const CalibratorOptions& options);

/// Settles the data: board bends, outliers, views that do not fit, weights. Regularises a lens that the views
/// do not determine.
[[nodiscard]] ModelSolution withDataSettled(ModelSolution solution, const PreparedViews& given,
                                            const CalibratorOptions& options);

}  // namespace alidade
