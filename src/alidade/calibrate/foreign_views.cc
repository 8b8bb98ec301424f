// SPDX-License-Identifier: MIT
#include "alidade/calibrate/foreign_views.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "alidade/calibrate/renumbering.h"
#include "alidade/calibrate/robust_weighting.h"
#include "alidade/calibrate/view_fit.h"
#include "alidade/core/text.h"

namespace alidade {
namespace {

// Of the views in use.
struct Misfits {
  std::vector<ViewFit> fits;
  std::vector<double> ratios;
  double stand_out = 0;  // ratio
};

Misfits misfitsInUse(const Estimation& e) {
  Misfits misfits;
  for (std::size_t v = 0; v < e.views.size(); ++v) {
    misfits.fits.push_back(fitInUse(e, v));
    misfits.ratios.push_back(misfitRatio(misfits.fits.back(), noiseSigma(e)));
  }
  misfits.stand_out = standOutRatio(misfits.ratios);
  return misfits;
}

}  // namespace

void setAsideForeignViews(Estimation& e) {
  while (e.misfits.size() < e.views.size()) {
    const Misfits misfits = misfitsInUse(e);
    std::size_t worst = e.views.size();
    for (std::size_t v = 0; v < e.views.size(); ++v) {
      if (!isForeign(e.board, misfits.fits[v], noiseSigma(e), misfits.stand_out)) continue;
      if (worst == e.views.size() || misfits.ratios[v] > misfits.ratios[worst]) worst = v;
    }
    if (worst == e.views.size()) break;
    setAside(e, worst);
    requireViews(e);
    settle(e);
  }
}

bool readmitViews(Estimation& e) {
  if (e.misfits.empty()) return false;
  const double stand_out = misfitsInUse(e).stand_out;
  std::vector<View> still_out;
  bool is_changed = false;
  for (View& view : e.misfits) {
    const auto fit = fitAlone(e, view);
    if (!fit || isForeign(e.board, *fit, noiseSigma(e), stand_out)) {
      still_out.push_back(std::move(view));
      continue;
    }
    const auto at =
        std::upper_bound(e.views.begin(), e.views.end(), view,
                         [](const View& a, const View& b) { return naturalLess(a.image, b.image); }) -
        e.views.begin();
    e.views.insert(e.views.begin() + at, std::move(view));
    e.observations.insert(e.observations.begin() + at, fit->observations);
    e.state.camera_from_board.insert(e.state.camera_from_board.begin() + at, fit->camera_from_board);
    is_changed = true;
  }
  e.misfits = std::move(still_out);
  if (!is_changed) return false;
  settle(e);
  return true;
}

bool setAsideMisnumberedViews(Estimation& e) {
  constexpr std::size_t kFewOutliers = 3;  // fewer are no row and no column
  bool is_changed = false;
  for (std::size_t v = e.views.size(); v-- > 0;) {
    if (countOutliers(fitInUse(e, v), noiseSigma(e)) < kFewOutliers || !fittingOrder(e, e.views[v])) continue;
    std::erase_if(e.outliers, [&](const Outlier& o) { return o.image == e.views[v].image; });
    setAside(e, v);
    is_changed = true;
  }
  if (!is_changed) return false;
  requireViews(e);
  settle(e);
  return true;
}

}  // namespace alidade
