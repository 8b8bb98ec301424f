// SPDX-License-Identifier: MIT
#include "alidade/calibrate/clean/outliers.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "alidade/adjust/board/solve.h"
#include "alidade/calibrate/clean/renumbering.h"
#include "alidade/calibrate/clean/view_fit.h"

namespace alidade {
namespace {

// Misfits of the views in use.
struct Misfits {
  std::vector<ViewFit> fits;
  std::vector<double> ratios;
  double stand_out = 0;  // as a ratio
};

Misfits misfitsInUse(const Fit& fit, const PreparedViews& given) {
  Misfits misfits;
  for (std::size_t v = 0; v < fit.views.size(); ++v) {
    misfits.fits.push_back(fitInUse(fit, v, given.views[fit.views[v].source]));
    misfits.ratios.push_back(misfitRatio(misfits.fits.back(), noiseSigma(fit)));
  }
  misfits.stand_out = standOutRatio(misfits.ratios);
  return misfits;
}

std::optional<std::size_t> worstForeignView(const Fit& fit, const PreparedViews& given) {
  const Misfits misfits = misfitsInUse(fit, given);
  std::optional<std::size_t> worst;
  for (std::size_t v = 0; v < fit.views.size(); ++v) {
    if (!isForeign(fit, misfits.fits[v], misfits.stand_out)) continue;
    if (!worst || misfits.ratios[v] > misfits.ratios[*worst]) worst = v;
  }
  return worst;
}

bool haveSameIds(const std::vector<Observation>& a, const std::vector<Observation>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const Observation& x, const Observation& y) { return x.id == y.id; });
}

// Judges all corners again; false if the outliers are the same as before.
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

void setAsideForeignViews(SettledFit& now, const PreparedViews& given, const CancelFlag* cancel) {
  while (2 * now.fit.views.size() > given.views.size()) {
    const auto worst = worstForeignView(now.fit, given);
    if (!worst) break;
    now.fit = withoutView(now.fit, *worst);
    requireViews(given, now.fit);
    now = settled(std::move(now.fit), cancel);
  }
}

bool readmitViews(SettledFit& now, const PreparedViews& given, const CancelFlag* cancel) {
  const std::vector<std::size_t> left_out = viewsLeftOut(given, now.fit);
  if (left_out.empty()) return false;
  const double stand_out = misfitsInUse(now.fit, given).stand_out;
  std::vector<std::pair<std::size_t, ViewFit>> fitting;
  for (const std::size_t v : left_out) {
    auto view = fitAlone(now.fit, given.views[v]);
    if (!view || isForeign(now.fit, *view, stand_out)) continue;
    fitting.emplace_back(v, *std::move(view));
  }
  if (fitting.empty()) return false;
  for (auto& [source, view] : fitting)
    addView(now.fit, source, std::move(view.corners), view.camera_from_board, view.board);
  for (FitView& view : now.fit.views) view.image = given.views[view.source].image;
  now = settled(std::move(now.fit), cancel);
  return true;
}

bool setAsideMisnumberedViews(SettledFit& now, const PreparedViews& given, const CancelFlag* cancel) {
  constexpr std::size_t kFewOutliers = 3;  // too few to be a row or a column
  std::vector<bool> is_out(now.fit.views.size());
  bool is_changed = false;
  for (std::size_t v = 0; v < now.fit.views.size(); ++v) {
    const View& view = given.views[now.fit.views[v].source];
    if (countOutliers(fitInUse(now.fit, v, view), noiseSigma(now.fit)) < kFewOutliers) continue;
    if (!fittingOrder(now.fit, view)) continue;
    is_out[v] = true;
    is_changed = true;
  }
  if (!is_changed) return false;
  now.fit = withoutViews(now.fit, is_out);
  requireViews(given, now.fit);
  now = settled(std::move(now.fit), cancel);
  return true;
}

SettledFit withoutOutliers(SettledFit settled, const PreparedViews& given, const CancelFlag* cancel) {
  bool may_readmit = true;
  for (int round = 0; round < kMaxRounds; ++round) {
    // Views first, because the remaining ones have enough corners.
    setAsideForeignViews(settled, given, cancel);
    if (leaveOutCorners(settled.fit, given, cancel)) continue;
    // Once only, or a borderline view would alternate for ever.
    if (std::exchange(may_readmit, false) && readmitViews(settled, given, cancel)) continue;
    if (!setAsideMisnumberedViews(settled, given, cancel)) return settled;
  }
  settled.is_settled = false;
  return settled;
}

}  // namespace alidade
