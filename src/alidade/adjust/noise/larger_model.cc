// SPDX-License-Identifier: MIT
#include "alidade/adjust/noise/larger_model.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "alidade/adjust/board/errors.h"
#include "alidade/adjust/board/solve.h"
#include "alidade/adjust/noise/cross_validation.h"
#include "alidade/adjust/noise/model_soundness.h"
#include "alidade/camera/model_traits.h"
#include "alidade/camera/same_lens.h"

namespace alidade {
namespace {

// A few steps show if there is anything to gain.
constexpr int kGlance = 5;

// The larger model on the same corners, with the same loss and boards, and without a prior.
Fit enlarged(const Fit& fit, std::string_view id) {
  Fit larger = fit;
  FitCamera& camera = onlyCamera(larger);
  setLens(id, closestByName(cameraOf(camera), id), camera);
  camera.weak_prior = {};
  fixShapes(larger);
  return larger;
}

Fit solvedLarger(Fit larger, int max_iterations, const CancelFlag* cancel) {
  constexpr double kFunctionTolerance = 1e-8;  // share of the cost: far below a relevant gain
  return solve(
      std::move(larger),
      {.max_iterations = max_iterations, .function_tolerance = kFunctionTolerance, .cancel = cancel});
}

// True if the gain is real, by an F test of the further parameters: the decrease of the sum of squares per
// parameter over the variance that the larger model leaves, which is 1 on average if they are not needed. For
// a lens without distortion, the test alone decides. No real distortion follows a formula exactly, and with
// enough corners every difference is significant, so between distortions the gain must also be worthwhile.
bool isGain(const Fit& lean, const Fit& larger) {
  constexpr double kNeededF = 10;           // exceeded by chance once in a billion cases
  constexpr double kWorthwhileShare = 0.1;  // share of the sum of squares: 5 % of the RMS
  const std::size_t num_params = onlyCamera(lean).params.size();
  const std::size_t num_larger_params = onlyCamera(larger).params.size();
  const double needed_share = num_params > kNumAffine ? kWorthwhileShare : 0.0;
  const std::size_t num_corners = numCorners(lean);
  const auto extra = static_cast<double>(num_larger_params - num_params);
  const double freedom = 2.0 * static_cast<double>(num_corners) - static_cast<double>(num_larger_params) -
                         6.0 * static_cast<double>(lean.views.size()) - numFreeOffsets(lean);
  const double drop = 2 * (cornersCost(lean) - larger.summary.cost);
  return drop / extra > kNeededF * std::max(2 * larger.summary.cost, noiseFloor(num_corners)) / freedom &&
         drop > needed_share * 2 * cornersCost(lean);
}

// The next larger model solved on the same corners, if it explains them significantly better and is sound.
std::optional<Fit> largerFit(const Fit& fit, const CancelFlag* cancel) {
  const FitCamera& camera = onlyCamera(fit);
  const ModelTraits* const next = nextLargerModel(camera.model);
  // Parameters are fixed by the user's choice; a larger model would not be comparable.
  if (next == nullptr || !camera.constraint.isNone() || fit.summary.termination == Termination::kFailed)
    return std::nullopt;
  Fit larger = solvedLarger(enlarged(fit, next->id), kGlance, cancel);
  if (!isGain(fit, larger)) return std::nullopt;
  // If these views do not determine all parameters of the larger model, the solver drifts endlessly.
  constexpr int kPatience = 100;
  larger = solvedLarger(std::move(larger), kPatience, cancel);
  if (!isGain(fit, larger) || unsoundnessOf(larger)) return std::nullopt;
  return larger;
}

// Both RMS values use the weights of the model in use, as the comparison does.
BetterModel betterModelOf(const Fit& fit, const Fit& larger) {
  return {.id = onlyCamera(larger).model,
          .rms_px = weightedRms(larger),
          .lean_rms_px = weightedRms(fit),
          .params = onlyCamera(larger).params};
}

// If a part of the views does not determine one of the models, or its camera does not see all corners of the
// others, the fit alone decides.
bool predictsBetter(const Fit& fit, const Fit& larger, const CancelFlag* cancel) {
  const auto lean = heldOutErrors(fit, 1, cancel);
  const auto rich = heldOutErrors(larger, 1, cancel);
  if (!lean || !rich) return true;
  if (holdoutReport(lean).num_unseen > 0 || holdoutReport(rich).num_unseen > 0) return true;
  return excessOf(scoreOf(*lean, fit), scoreOf(*rich, larger))
      .isWorth(onlyCamera(larger).params.size() - onlyCamera(fit).params.size());
}

}  // namespace

std::optional<BetterModel> betterModel(const Fit& fit, const CancelFlag* cancel) {
  const auto larger = largerFit(fit, cancel);
  if (!larger) return std::nullopt;
  return betterModelOf(fit, *larger);
}

std::optional<BetterModel> neededModel(const Fit& fit, const CancelFlag* cancel) {
  const auto larger = largerFit(fit, cancel);
  if (!larger || !predictsBetter(fit, *larger, cancel)) return std::nullopt;
  return betterModelOf(fit, *larger);
}

double dropAtAGlance(const Fit& fit, const std::string& larger_id, const CancelFlag* cancel) {
  const Fit glance = solvedLarger(enlarged(fit, larger_id), kGlance, cancel);
  if (glance.summary.termination == Termination::kFailed) return 0;
  double floor = 0;
  for (const FitView& view : fit.views) floor += noiseFloor(view.corners.size());
  return 2 * (cornersCost(fit) - glance.summary.cost) / (2 * cornersCost(fit) + floor);
}

}  // namespace alidade
