// SPDX-License-Identifier: MIT
#include "alidade/calibrate/outlier_rounds.h"

#include <algorithm>
#include <utility>

#include "alidade/calibrate/foreign_views.h"
#include "alidade/calibrate/robust_weighting.h"
#include "alidade/calibrate/view_fit.h"

namespace alidade {
namespace {

bool isSame(const std::vector<Outlier>& a, const std::vector<Outlier>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Outlier& x, const Outlier& y) {
    return x.image == y.image && x.corner_id == y.corner_id;
  });
}

// Judges all corners anew; false if the same ones came out as before.
bool leaveOutCorners(Estimation& e) {
  const double sigma = noiseSigma(e);
  std::vector<Outlier> outliers;
  Observations kept;
  for (std::size_t v = 0; v < e.views.size(); ++v) {
    const ViewFit fit = fitInUse(e, v);
    std::vector<Observation> good;
    for (std::size_t i = 0; i < fit.errors.size(); ++i) {
      if (isOutlier(fit.observations[i], fit.errors[i], sigma)) {
        outliers.push_back({e.views[v].image, e.views[v].corners[i].id, fit.errors[i]});
      } else {
        good.push_back(fit.observations[i]);
      }
    }
    kept.push_back(std::move(good));
  }
  if (isSame(outliers, e.outliers)) return false;
  e.outliers = std::move(outliers);
  e.observations = std::move(kept);
  solve(e);
  return true;
}

}  // namespace

void leaveOutOutliers(Estimation& e) {
  bool may_readmit = true;
  for (int round = 0; round < kMaxRounds; ++round) {
    // Views first: those that stay have corners enough left.
    setAsideForeignViews(e);
    if (leaveOutCorners(e)) continue;
    // Once only, or a view on the verge would come and go for ever.
    if (std::exchange(may_readmit, false) && readmitViews(e)) continue;
    if (!setAsideMisnumberedViews(e)) return;
  }
  e.is_settled = false;
}

}  // namespace alidade
