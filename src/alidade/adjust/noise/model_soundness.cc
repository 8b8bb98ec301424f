// SPDX-License-Identifier: MIT
#include "alidade/adjust/noise/model_soundness.h"

#include <numbers>

#include "alidade/adjust/noise/covariance.h"
#include "alidade/camera/image_domain.h"
#include "alidade/core/number_text.h"

namespace alidade {

std::size_t numCornersOutside(const Fit& fit, const AnyCamera& camera) {
  std::size_t count = 0;
  for (const FitView& view : fit.views) {
    const SE3 pose = cameraFromBoard(fit, view);
    for (const Observation& corner : cornersOnShape(fit, view)) {
      if (!camera.projectPoint(pose * corner.p_board).ok()) ++count;
    }
  }
  return count;
}

std::optional<Unsoundness> unsoundnessOf(const Fit& fit) {
  constexpr double kMinCondition = 1e-11;  // for parameters scaled to the same size
  if (fit.summary.termination != Termination::kConverged) {
    return Unsoundness{
        .id = "not_converged",
        .text = "its parameters diverge: " + std::string(terminationName(fit.summary.termination))};
  }
  const IntrinsicsInformation information = intrinsicsInformation(fit);
  if (!information.inverse || information.condition < kMinCondition)
    return Unsoundness{.id = "ill_conditioned", .text = "these views leave its parameters undetermined"};
  const FitCamera& of = onlyCamera(fit);
  const AnyCamera camera = cameraOf(of);
  if (numCornersOutside(fit, camera) > 0)
    return Unsoundness{.id = "corners_outside_domain", .text = "it cannot project all of the corners"};
  if (!foldsInsideImage(camera, of.size)) return std::nullopt;
  return Unsoundness{.id = "folds_in_image",
                     .text = "it folds over inside the image, " +
                             numberText("%.0f", camera.cone().max_angle_rad * 180 / std::numbers::pi) +
                             " degrees from the axis",
                     .folds = true};
}

}  // namespace alidade
