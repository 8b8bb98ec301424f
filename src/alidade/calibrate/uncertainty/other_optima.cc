// SPDX-License-Identifier: MIT
#include "alidade/calibrate/uncertainty/other_optima.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "alidade/adjust/board/errors.h"
#include "alidade/adjust/board/pose_search.h"
#include "alidade/adjust/board/solve.h"
#include "alidade/adjust/noise/model_soundness.h"
#include "alidade/adjust/noise/shape_information.h"
#include "alidade/calibrate/bend/shape_fit.h"
#include "alidade/calibrate/uncertainty/aligned_difference.h"

namespace alidade {
namespace {

constexpr double kBeyondSigmas = 3;

// Variance for deciding whether a difference of costs is noise.
double variance(const Uncertainty& known) {
  const double by_noise = known.coordinate_sigma_px * known.coordinate_sigma_px;
  return known.isNoiseExceeded() ? by_noise * std::max(1.0, known.by_views->excess) : by_noise;
}

// Part of twice the other camera's cost that its own bends would save.
double savedByBends(const Fit& fit, const Fit& other) {
  if (!isShapeEstimated(fit)) return 0;
  const auto info = shapeInformation(other, estimatedShapes(fit));
  return info ? info->drop : 0;
}

double largestSigmas(const Fit& fit, const Uncertainty& known, std::span<const double> params) {
  double largest = 0;
  for (std::size_t i = 0; i < onlyCamera(fit).numLensParams(); ++i) {
    const double std = known.parameterStd(static_cast<int>(i));
    const double difference = std::abs(params[i] - onlyCamera(fit).params[i]);
    if (std > 0) largest = std::max(largest, difference / std);
  }
  return largest;
}

std::optional<OtherOptimum> otherOptimum(const Fit& fit, const std::vector<double>& params,
                                         const Uncertainty& known, const CancelFlag* cancel) {
  // Poses from the corners' rays, because views may have been removed or added since the search.
  Fit start = fit;
  FitCamera& of = onlyCamera(start);
  setLens(of.model, std::span(params).first(of.numLensParams()), of);
  fixShapes(start);
  auto posed = posedAnew(std::move(start));
  if (!posed) return std::nullopt;
  const Fit at = solve(*std::move(posed), {.cancel = cancel});
  if (unsoundnessOf(at)) return std::nullopt;
  const FitCamera& camera = onlyCamera(at);
  const auto num_lens = static_cast<std::ptrdiff_t>(camera.numLensParams());
  const double twice_more = 2 * (at.summary.cost - fit.summary.cost) - savedByBends(fit, at);
  OtherOptimum other{.params = {camera.params.begin(), camera.params.begin() + num_lens},
                     .rms_px = weightedRms(at),
                     .excess_chi2 = twice_more / variance(known),
                     .sigmas = largestSigmas(fit, known, camera.params)};
  if (!(other.excess_chi2 < kNoiseChi2) || !(other.sigmas > kBeyondSigmas)) return std::nullopt;
  other.projection_px =
      largestDifference(cameraOf(fit), cameraOf(camera.model, other.params), known.projection_far->pixels);
  return other;
}

}  // namespace

std::vector<OtherOptimum> otherOptima(const Fit& fit, const std::vector<std::vector<double>>& close_params,
                                      const Uncertainty& known, const CancelFlag* cancel) {
  std::vector<OtherOptimum> others;
  if (!known.covariance || !known.projection_far) return others;
  for (const std::vector<double>& params : close_params) {
    if (auto other = otherOptimum(fit, params, known, cancel)) others.push_back(std::move(*other));
  }
  std::ranges::stable_sort(others, {}, &OtherOptimum::excess_chi2);
  return others;
}

}  // namespace alidade
