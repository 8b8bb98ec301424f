// SPDX-License-Identifier: MIT
#include "alidade/calibrate/calibrator.h"

#include <utility>

#include "alidade/calibrate/choose/model_choice.h"
#include "alidade/calibrate/result_of.h"
#include "alidade/calibrate/start/held_params.h"
#include "alidade/camera/model_list.h"

namespace alidade {
namespace {

// Enough to bring two cameras together.
std::vector<Eigen::Vector2d> someCorners(const Fit& fit) {
  constexpr std::size_t kEnough = 2000;
  const std::size_t step = numCorners(fit) / kEnough + 1;
  std::vector<Eigen::Vector2d> pixels;
  std::size_t i = 0;
  for (const FitView& view : fit.views) {
    for (const Observation& corner : view.corners) {
      if (i++ % step == 0) pixels.push_back(corner.pixel);
    }
  }
  return pixels;
}

std::optional<ModelSpread> spreadOf(const ChosenModel& chosen, const CalibrationResult& result) {
  if (chosen.rivals.empty() || !result.projection_far) return std::nullopt;
  return modelSpread(AnyCamera::make(result.camera.modelId(), chosen.params), chosen.rivals,
                     someCorners(chosen.solution.fit), *result.projection_far);
}

}  // namespace

CalibrationResult calibrate(const Checkerboard& board, std::vector<View> views,
                            const CalibratorOptions& options) {
  CalibratorOptions named = options;
  named.model = namedModel(options);
  if (named.model != kAutoModel)
    static_cast<void>(parameterNames(named.model));  // throws for an unknown model
  static_cast<void>(constraintOf(named));
  const PreparedViews given = prepareViews(board, std::move(views));
  if (named.model == kAutoModel) {
    ChosenModel chosen = chooseModel(board, given, named);
    CalibrationResult result = resultOf(chosen.solution, given, named);
    result.model_spread = spreadOf(chosen, result);
    result.model_choice = std::move(chosen.choice);
    result.findings = judge(result);
    return result;
  }
  const ModelSolution solution = withDataSettled(fittedPlainly(board, given, named), given, named);
  CalibrationResult result = resultOf(solution, given, named);
  result.better_model = neededModel(solution.fit, named.cancel);
  result.findings = judge(result);
  return result;
}

}  // namespace alidade
