// SPDX-License-Identifier: MIT
#include "alidade/rig/shared_models.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

#include "alidade/camera/lens_shapes.h"
#include "alidade/core/mapped.h"

namespace alidade {
namespace {

// Excess of the held-out RMS over that of the camera's best model, as a share.
struct Excess {
  double share = std::numeric_limits<double>::infinity();  // infinite: not tried, or unfit
  double std = 0;

  [[nodiscard]] bool isTried() const { return std::isfinite(share); }
  [[nodiscard]] bool isClear() const {
    constexpr double kSigmas = 3;
    constexpr double kLeastShare = 0.02;
    return share > std::max(kLeastShare, kSigmas * std);
  }
};

std::string_view modelOf(const Calibration& alone) {
  return onlyCamera(alone.fit).model;
}

Excess excessOf(const Calibration& alone, std::string_view model) {
  const std::vector<ModelCandidate>& candidates = alone.choice.model->candidates;
  const auto candidate = std::ranges::find(candidates, model, &ModelCandidate::id);
  // A larger model that was not cross-validated was not tried.
  if (candidate == candidates.end() || !std::isfinite(candidate->excess)) return {};
  return {.share = candidate->excess, .std = candidate->excess_std};
}

double focalOf(const Calibration& alone) {
  return axisFocal(alone.camera()).mean();
}

// Groups of cameras that are treated as equal, without those of which the user named the model.
std::vector<std::vector<std::size_t>> equalCameras(std::span<const Calibration> alone) {
  constexpr double kSimilar = 1.2;  // ratio of focal lengths
  std::vector<std::size_t> order;
  for (std::size_t c = 0; c < alone.size(); ++c) {
    if (alone[c].choice.model) order.push_back(c);
  }
  std::ranges::stable_sort(order, {}, [&](std::size_t c) { return focalOf(alone[c]); });
  std::vector<std::vector<std::size_t>> groups;
  for (const std::size_t c : order) {
    const auto at = std::ranges::find_if(groups, [&](const std::vector<std::size_t>& group) {
      const Calibration& shortest = alone[group.front()];
      return shortest.imageSize() == alone[c].imageSize() && focalOf(alone[c]) < kSimilar * focalOf(shortest);
    });
    if (at != groups.end()) {
      at->push_back(c);
    } else {
      groups.push_back({c});
    }
  }
  return groups;
}

}  // namespace

std::vector<std::string> sharedModels(std::span<const Calibration> alone) {
  std::vector<std::string> models =
      mapped(alone, [](const Calibration& calibration) { return std::string(modelOf(calibration)); });
  for (const std::vector<std::size_t>& group : equalCameras(alone)) {
    // The number of cameras in which a model was not tried, and the sum of its excess in the others.
    const auto costOf = [&](std::size_t of) {
      std::pair<int, double> cost = {0, 0};
      for (const std::size_t c : group) {
        const Excess excess = excessOf(alone[c], modelOf(alone[of]));
        if (excess.isTried())
          cost.second += static_cast<double>(numCorners(alone[c].fit)) * excess.share;
        else
          ++cost.first;
      }
      return cost;
    };
    const std::string_view shared = modelOf(alone[*std::ranges::min_element(group, {}, costOf)]);
    for (const std::size_t c : group) {
      const Excess excess = excessOf(alone[c], shared);
      if (!excess.isTried() || !excess.isClear()) models[c] = shared;
    }
  }
  return models;
}

}  // namespace alidade
