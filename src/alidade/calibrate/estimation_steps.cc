// SPDX-License-Identifier: MIT
#include "alidade/calibrate/estimation_steps.h"

#include "alidade/calibrate/estimation_start.h"
#include "alidade/calibrate/outlier_rounds.h"
#include "alidade/calibrate/robust_weighting.h"
#include "alidade/calibrate/shape_step.h"
#include "alidade/calibrate/view_preparation.h"
#include "alidade/calibrate/weak_prior.h"

namespace alidade {

void fitPlainly(Estimation& estimation) {
  excludeUnusable(estimation);
  startEstimation(estimation);
  solveRobustly(estimation);
  compareRivals(estimation);
}

void settleData(Estimation& estimation) {
  holdTogether(estimation);
  estimateShape(estimation);
  leaveOutOutliers(estimation);
  if (!refineShape(estimation)) leaveOutOutliers(estimation);
  holdTogether(estimation);  // on the corners that are left
}

}  // namespace alidade
