// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "alidade/calibrate/choose/choice.h"
#include "alidade/calibrate/start/options.h"
#include "alidade/calibrate/start/prepared_views.h"

namespace alidade {

/// A camera of one model that fits the views, and how it was found.
struct ModelSolution {
  Fit fit;
  Choice choice;  ///< but for what concerns other models
  /// Parameters of other optima that were about as good on all views, for otherOptima().
  std::vector<std::vector<double>> close_params;
};

/// From views to a camera that fits them, all corners counting by the robust loss alone.
/// @param options  with a model that is named
/// @throws Error (kInput) if no camera of the model explains the views
[[nodiscard]] ModelSolution fittedPlainly(const PreparedViews& given, const CalibratorOptions& options);

/// Settles what the corners are: the boards' bends, outliers, views that do not fit, weights. Regularises a
/// lens that they do not determine.
[[nodiscard]] ModelSolution withDataSettled(ModelSolution solution, const PreparedViews& given,
                                            const CalibratorOptions& options);

}  // namespace alidade
