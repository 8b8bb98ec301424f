// SPDX-License-Identifier: MIT
#include "alidade/calibrate/other_optima.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "alidade/calibrate/far_difference.h"
#include "alidade/calibrate/model_soundness.h"
#include "alidade/calibrate/shape_information.h"
#include "alidade/calibrate/start_poses.h"

namespace alidade {
namespace {

constexpr double kBeyondSigmas = 3;

// Poses by the corners' rays: since the search, views may have gone out of use or come back.
std::optional<BundleState> posed(const Estimation& e, const std::vector<double>& params) {
  PosedCamera camera{.params = params, .poses = {}};
  camera.poses.resize(e.views.size());
  improvePoses(e.options.model, e.board, e.views, e.loss, camera);
  BundleState state{.params = params, .camera_from_board = {}};
  for (const std::optional<SE3>& pose : camera.poses) {
    if (!pose) return std::nullopt;
    state.camera_from_board.push_back(*pose);
  }
  return state;
}

// The variance by which a difference of costs is no more than noise.
double variance(const CalibrationResult& result) {
  const double by_noise = result.coordinate_sigma_px * result.coordinate_sigma_px;
  return result.isNoiseExceeded() ? by_noise * std::max(1.0, result.by_views->excess) : by_noise;
}

// Of twice the cost, what a bend of the other camera's own would save.
double savedByBend(const Estimation& e, const BundleState& state) {
  if (!e.shape.is_estimated) return 0;
  const auto info = shapeInformation(e.options.model, e.board, e.observations, state, e.loss, e.constraint,
                                     e.weak_prior.prior);
  return info ? info->drop : 0;
}

double largestSigmas(const CalibrationResult& result, std::span<const double> params) {
  double largest = 0;
  for (std::size_t i = 0; i < params.size(); ++i) {
    const double std = result.statedStd(static_cast<int>(i));
    const double difference = std::abs(params[i] - result.camera.parameters()[i]);
    if (std > 0) largest = std::max(largest, difference / std);
  }
  return largest;
}

double projectionDifference(const AnyCamera& a, const AnyCamera& b, std::span<const Eigen::Vector2d> pixels) {
  double largest = std::numeric_limits<double>::quiet_NaN();
  for (const double difference : farDifferences(a, b, pixels, pixels))
    largest = std::fmax(largest, difference);
  return largest;
}

std::optional<OtherOptimum> otherOptimum(const Estimation& e, const CalibrationResult& result,
                                         const std::vector<double>& params) {
  std::optional<BundleState> state = posed(e, params);
  if (!state) return std::nullopt;
  const BundleSummary summary = solveBundle(
      e.options.model, e.observations, *state,
      {.loss = e.loss, .constraint = e.constraint, .prior = e.weak_prior.prior, .cancel = e.options.cancel});
  if (unsoundnessOf(e.options.model, result.image_size, e.observations, *state, summary, e.constraint))
    return std::nullopt;
  const double twice_more = 2 * (summary.cost - e.summary.cost) - savedByBend(e, *state);
  OtherOptimum other{.params = state->params,
                     .rms_px = weightedRms(e.options.model, e.observations, *state),
                     .excess_chi2 = twice_more / variance(result),
                     .sigmas = largestSigmas(result, state->params)};
  if (!(other.excess_chi2 < kNoiseChi2) || !(other.sigmas > kBeyondSigmas)) return std::nullopt;
  other.projection_px = projectionDifference(result.camera, AnyCamera::make(e.options.model, other.params),
                                             result.projection_far->pixels);
  return other;
}

}  // namespace

std::vector<OtherOptimum> otherOptima(const Estimation& e, const CalibrationResult& result) {
  std::vector<OtherOptimum> others;
  if (!result.covariance || !result.projection_far) return others;
  for (const std::vector<double>& params : e.close_params) {
    if (auto other = otherOptimum(e, result, params)) others.push_back(std::move(*other));
  }
  std::stable_sort(others.begin(), others.end(), [](const OtherOptimum& a, const OtherOptimum& b) {
    return a.excess_chi2 < b.excess_chi2;
  });
  return others;
}

}  // namespace alidade
