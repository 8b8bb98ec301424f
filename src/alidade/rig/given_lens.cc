// SPDX-License-Identifier: MIT
#include "alidade/rig/given_lens.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "alidade/adjust/errors.h"
#include "alidade/adjust/solve.h"
#include "alidade/calibrate/uncertainty/aligned_difference.h"
#include "alidade/camera/any_camera.h"
#include "alidade/core/statistics.h"

namespace alidade {

std::optional<LensMisfit> givenLensMisfit(const Fit& fit, const CancelFlag* cancel) {
  constexpr double kSure = 4.5;  // standard deviations of a normal variable
  Fit freed = fit;
  onlyCamera(freed).constraint = {};
  freed = solve(std::move(freed), {.cancel = cancel});
  if (freed.summary.termination == Termination::kFailed) return std::nullopt;
  const auto num_params = static_cast<double>(onlyCamera(fit).params.size());
  const double freedom =
      2 * static_cast<double>(numCorners(fit)) - num_params - 6 * static_cast<double>(fit.placements.size());
  const double gain = fit.summary.cost - freed.summary.cost;
  if (freedom < 1 || !(gain > 0)) return std::nullopt;
  const double f = (gain / num_params) / (freed.summary.cost / freedom);
  if (normalOfF(f, num_params, freedom) < kSure) return std::nullopt;
  std::vector<Eigen::Vector2d> pixels;
  for (const FitView& view : fit.views) {
    for (const Observation& corner : view.corners) pixels.push_back(corner.pixel);
  }
  const auto cameraOf = [](const Fit& of) {
    return AnyCamera::make(onlyCamera(of).model, onlyCamera(of).params);
  };
  std::vector<double> differences = alignedDifferences(cameraOf(fit), cameraOf(freed), pixels, pixels);
  std::erase_if(differences, [](double difference) { return std::isnan(difference); });
  if (differences.empty()) return std::nullopt;
  constexpr double kShare = 0.95;
  const auto at =
      differences.begin() + static_cast<std::ptrdiff_t>(kShare * static_cast<double>(differences.size() - 1));
  std::ranges::nth_element(differences, at);
  return LensMisfit{.effect_px = *at, .freed_rms_px = rms(freed)};
}

}  // namespace alidade
