// SPDX-License-Identifier: MIT
#include "alidade/calibrate/estimation_steps.h"

#include "alidade/calibrate/estimation_start.h"
#include "alidade/calibrate/outlier_rounds.h"
#include "alidade/calibrate/robust_weighting.h"
#include "alidade/calibrate/shape_step.h"
#include "alidade/calibrate/view_preparation.h"

namespace alidade {

void fitPlainly(Estimation& estimation) {
  excludeUnusable(estimation);
  startEstimation(estimation);
  solveRobustly(estimation);
  compareRivals(estimation);
}

void settleData(Estimation& estimation) {
  estimateShape(estimation);
  leaveOutOutliers(estimation);
  if (!refineShape(estimation)) leaveOutOutliers(estimation);
}

}  // namespace alidade
