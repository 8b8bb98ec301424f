// SPDX-License-Identifier: MIT
#include "alidade/calibrate/clean/dropped.h"

#include <algorithm>

#include "alidade/calibrate/clean/view_fit.h"
#include "alidade/calibrate/clean/view_reason.h"
#include "alidade/core/text.h"

namespace alidade {
namespace {

std::vector<Outlier> outliersOf(const Fit& fit, const PreparedViews& given) {
  std::vector<Outlier> outliers;
  for (std::size_t v = 0; v < fit.views.size(); ++v) {
    const View& view = given.views[fit.views[v].source];
    const ViewFit all = fitInUse(fit, v, view);
    auto used = fit.views[v].corners.begin();
    for (std::size_t i = 0; i < all.corners.size(); ++i) {
      if (used != fit.views[v].corners.end() && used->id == all.corners[i].id) {
        ++used;
      } else {
        outliers.push_back({fit.views[v].source, view.image, all.corners[i].id, all.errors[i]});
      }
    }
  }
  return outliers;
}

}  // namespace

std::size_t Dropped::numMisfits() const {
  return static_cast<std::size_t>(
      std::count_if(views.begin(), views.end(), [](const ExcludedView& view) { return view.is_misfit; }));
}

double Dropped::outlierShare(const Fit& fit) const {
  const auto num_out = static_cast<double>(outliers.size());
  return num_out / (num_out + static_cast<double>(numCorners(fit)));
}

Dropped droppedFrom(const Fit& fit, const PreparedViews& given, const CancelFlag* cancel) {
  Dropped dropped{.views = given.excluded, .repeated = given.repeated, .outliers = outliersOf(fit, given)};
  for (const std::size_t v : viewsLeftOut(given, fit)) {
    dropped.views.push_back(
        {given.views[v].image, misfitReason(fit, given.views[v], cancel), /*is_misfit=*/true});
  }
  std::sort(dropped.views.begin(), dropped.views.end(),
            [](const auto& a, const auto& b) { return naturalLess(a.image, b.image); });
  return dropped;
}

}  // namespace alidade
