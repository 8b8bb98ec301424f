// SPDX-License-Identifier: MIT
#include "alidade/calibrate/outlier_rounds.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "alidade/calibrate/robust_weighting.h"
#include "alidade/calibrate/view_preparation.h"

namespace alidade {
namespace {

// Beyond this many standard deviations a corner is not noise (chance 1e-14) and is left out by name.
constexpr double kOutlierSigmas = 8.0;

}  // namespace

// Outliers are judged anew in each round, among all corners, until the same ones come out.
void leaveOutOutliers(Estimation& e) {
  const double limit = kOutlierSigmas * e.loss.threshold_px / kLossSigmas;
  for (int round = 0; round < kMaxRounds; ++round) {
    std::vector<Outlier> outliers;
    Observations kept;
    std::vector<std::size_t> foreign;
    Observations all = observationsOf(e.board, e.views);
    weigh(e.noise, all);
    for (std::size_t v = 0; v < e.views.size(); ++v) {
      const auto errors =
          reprojectionErrors(e.options.model, e.state.params, e.state.camera_from_board[v], all[v]);
      std::vector<Observation> good;
      for (std::size_t i = 0; i < errors.size(); ++i) {
        if (std::sqrt(all[v][i].weight) * errors[i].norm() <= limit) {
          good.push_back(all[v][i]);
        } else {
          outliers.push_back({e.views[v].image, e.views[v].corners[i].id, errors[i]});
        }
      }
      if (2 * good.size() < errors.size() || good.size() < kMinCornersPerView) foreign.push_back(v);
      kept.push_back(std::move(good));
    }
    if (!foreign.empty()) {
      for (auto v = foreign.rbegin(); v != foreign.rend(); ++v) {
        kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(*v));
        std::erase_if(outliers, [&](const Outlier& o) { return o.image == e.views[*v].image; });
        exclude(e, *v, "most of its corners do not fit the camera that the other views agree on");
      }
      requireViews(e);
    }
    const bool is_same =
        foreign.empty() && outliers.size() == e.outliers.size() &&
        std::equal(outliers.begin(), outliers.end(), e.outliers.begin(), [](const auto& a, const auto& b) {
          return a.image == b.image && a.corner_id == b.corner_id;
        });
    e.outliers = std::move(outliers);
    if (is_same) return;
    e.observations = std::move(kept);
    solve(e);
  }
  e.is_settled = false;
}

}  // namespace alidade
