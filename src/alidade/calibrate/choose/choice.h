// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "alidade/adjust/larger_model.h"
#include "alidade/calibrate/bend/shape_step.h"
#include "alidade/calibrate/choose/model_candidate.h"
#include "alidade/calibrate/start/start.h"

namespace alidade {

/// What was decided on the way to a fit.
struct Choice {
  StartReport start = {};
  ShapeReport shape = {};
  bool is_settled = false;  ///< noise estimate and set of outliers came to rest in the rounds allowed
  std::optional<ModelChoice> model = {};         ///< where the model was not named
  std::optional<BetterModel> better_model = {};  ///< where it was
};

}  // namespace alidade
