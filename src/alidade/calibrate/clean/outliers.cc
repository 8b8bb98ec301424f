// SPDX-License-Identifier: MIT
#include "alidade/calibrate/clean/outliers.h"

#include <algorithm>
#include <utility>

#include "alidade/adjust/solve.h"
#include "alidade/calibrate/clean/foreign_views.h"
#include "alidade/calibrate/clean/view_fit.h"

namespace alidade {
namespace {

bool haveSameIds(const std::vector<Observation>& a, const std::vector<Observation>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const Observation& x, const Observation& y) { return x.id == y.id; });
}

// Judges all corners anew; false if the same ones come out as before.
bool leaveOutCorners(Fit& fit, const PreparedViews& given, const CancelFlag* cancel) {
  const double sigma = noiseSigma(fit);
  std::vector<std::vector<Observation>> kept;
  bool is_changed = false;
  for (std::size_t v = 0; v < fit.views.size(); ++v) {
    const ViewFit all = fitInUse(fit, v, given.views[fit.views[v].source]);
    std::vector<Observation>& good = kept.emplace_back();
    for (std::size_t i = 0; i < all.errors.size(); ++i) {
      if (!isOutlier(all.corners[i], all.errors[i], sigma)) good.push_back(all.corners[i]);
    }
    is_changed = is_changed || !haveSameIds(good, fit.views[v].corners);
  }
  if (!is_changed) return false;
  for (std::size_t v = 0; v < fit.views.size(); ++v) fit.views[v].corners = std::move(kept[v]);
  fit = solve(std::move(fit), {.cancel = cancel});
  return true;
}

}  // namespace

SettledFit withoutOutliers(SettledFit settled, const PreparedViews& given, const CancelFlag* cancel) {
  bool may_readmit = true;
  for (int round = 0; round < kMaxRounds; ++round) {
    // Views first: those that stay have corners enough left.
    setAsideForeignViews(settled, given, cancel);
    if (leaveOutCorners(settled.fit, given, cancel)) continue;
    // Once only, or a view on the verge would come and go for ever.
    if (std::exchange(may_readmit, false) && readmitViews(settled, given, cancel)) continue;
    if (!setAsideMisnumberedViews(settled, given, cancel)) return settled;
  }
  settled.is_settled = false;
  return settled;
}

}  // namespace alidade
