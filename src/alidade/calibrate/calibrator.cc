// SPDX-License-Identifier: MIT
#include "alidade/calibrate/calibrator.h"

#include <utility>

#include "alidade/calibrate/estimation.h"
#include "alidade/calibrate/estimation_steps.h"
#include "alidade/calibrate/held_params.h"
#include "alidade/calibrate/larger_model.h"
#include "alidade/calibrate/model_choice.h"
#include "alidade/calibrate/result_of.h"
#include "alidade/calibrate/shape_step.h"
#include "alidade/calibrate/view_preparation.h"
#include "alidade/calibrate/view_reason.h"
#include "alidade/camera/model_list.h"

namespace alidade {
namespace {

CalibrationResult withReasons(Estimation& estimation) {
  noteIgnoredBend(estimation);
  nameReasons(estimation);
  return resultOf(estimation);
}

// Enough to bring two cameras together.
std::vector<Eigen::Vector2d> someCorners(const Estimation& estimation) {
  constexpr std::size_t kEnough = 2000;
  std::size_t num_corners = 0;
  for (const auto& view : estimation.observations) num_corners += view.size();
  const std::size_t step = num_corners / kEnough + 1;
  std::vector<Eigen::Vector2d> pixels;
  std::size_t i = 0;
  for (const auto& view : estimation.observations) {
    for (const Observation& observation : view) {
      if (i++ % step == 0) pixels.push_back(observation.pixel);
    }
  }
  return pixels;
}

std::optional<ModelSpread> spreadOf(const ChosenModel& chosen, const CalibrationResult& result) {
  if (chosen.rivals.empty() || !result.projection_far) return std::nullopt;
  return modelSpread(AnyCamera::make(result.camera.modelId(), chosen.params), chosen.rivals,
                     someCorners(chosen.fit->estimation), *result.projection_far);
}

}  // namespace

CalibrationResult calibrate(const Checkerboard& board, std::vector<View> views,
                            const CalibratorOptions& options) {
  CalibratorOptions named = options;
  named.model = namedModel(options);
  if (named.model != kAutoModel)
    static_cast<void>(parameterNames(named.model));  // throws for an unknown model
  static_cast<void>(constraintOf(named));
  prepareViews(board, views);
  if (named.model == kAutoModel) {
    ChosenModel chosen = chooseModel(board, views, named);
    CalibrationResult result = withReasons(chosen.fit->estimation);
    result.model_spread = spreadOf(chosen, result);
    result.model_choice = std::move(chosen.choice);
    result.findings = judge(result);
    return result;
  }
  Estimation estimation(board, std::move(views), named);
  fitPlainly(estimation);
  settleData(estimation);
  CalibrationResult result = withReasons(estimation);
  result.better_model = neededModel(estimation);
  result.findings = judge(result);
  return result;
}

}  // namespace alidade
