// SPDX-License-Identifier: MIT
#include "alidade/calibrate/calibrator.h"

#include <utility>

#include "alidade/calibrate/estimation.h"
#include "alidade/calibrate/estimation_start.h"
#include "alidade/calibrate/larger_model.h"
#include "alidade/calibrate/outlier_rounds.h"
#include "alidade/calibrate/result_of.h"
#include "alidade/calibrate/robust_weighting.h"
#include "alidade/calibrate/shape_step.h"
#include "alidade/calibrate/view_preparation.h"
#include "alidade/calibrate/view_reason.h"
#include "alidade/calibrate/weak_prior.h"
#include "alidade/camera/model_list.h"

namespace alidade {

CalibrationResult calibrate(const Checkerboard& board, std::vector<View> views,
                            const CalibratorOptions& options) {
  static_cast<void>(parameterNames(options.model));  // throws for an unknown model
  prepareViews(board, views);
  Estimation estimation(board, std::move(views), options);
  excludeUnusable(estimation);
  startEstimation(estimation);
  solveRobustly(estimation);
  compareRivals(estimation);
  holdTogether(estimation);
  estimateShape(estimation);
  leaveOutOutliers(estimation);
  if (!refineShape(estimation)) leaveOutOutliers(estimation);
  holdTogether(estimation);  // on the corners that are left
  nameReasons(estimation);
  CalibrationResult result = resultOf(estimation);
  result.better_model = betterModel(estimation);
  result.findings = judge(result);
  return result;
}

}  // namespace alidade
