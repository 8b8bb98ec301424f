// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "alidade/adjust/board/fit.h"
#include "support/simulated_set.h"

namespace alidade {

/// A fit of a set's views that stands at some camera and at the set's poses; `Set` is a SimulatedSet or a
/// UserSet.
template <class Set>
[[nodiscard]] Fit fitAt(const Set& set, std::string model, std::vector<double> params,
                        HuberLoss loss = kNoLoss) {
  Fit fit = emptyFit(std::move(model), set.views.front().size, std::move(params), set.board, loss);
  for (std::size_t v = 0; v < set.views.size(); ++v)
    addView(fit, v, observationsOf(set.board, set.views[v]), set.poses[v]);
  return fit;
}

/// The same of a camera.
template <class Set>
[[nodiscard]] Fit fitAt(const Set& set, const AnyCamera& camera, HuberLoss loss = kNoLoss) {
  const auto params = camera.parameters();
  return fitAt(set, std::string(camera.modelId()), {params.begin(), params.end()}, loss);
}

/// The corners of each view.
[[nodiscard]] inline std::vector<std::vector<Observation>> cornersOf(const Fit& fit) {
  std::vector<std::vector<Observation>> views;
  for (const FitView& view : fit.views) views.push_back(view.corners);
  return views;
}

}  // namespace alidade
