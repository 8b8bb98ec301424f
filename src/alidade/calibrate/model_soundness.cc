// SPDX-License-Identifier: MIT
#include "alidade/calibrate/model_soundness.h"

#include <cmath>
#include <cstddef>
#include <numbers>

#include "alidade/calibrate/covariance.h"
#include "alidade/calibrate/number_text.h"

namespace alidade {

std::optional<Unsoundness> unsoundnessOf(std::string_view model_id, ImageSize size,
                                         std::span<const std::vector<Observation>> views,
                                         const BundleState& state, const BundleSummary& summary,
                                         const ParamConstraint& constraint) {
  constexpr double kMinCondition = 1e-11;  // of parameters scaled to the same size
  if (summary.termination != Termination::kConverged) {
    return Unsoundness{
        .id = "not_converged",
        .text = "its parameters run away without end: " + std::string(terminationName(summary.termination))};
  }
  const IntrinsicsInformation information = intrinsicsInformation(model_id, views, state, constraint);
  if (!information.inverse || information.scaled_condition < kMinCondition) {
    return Unsoundness{.id = "ill_conditioned", .text = "these views leave its parameters undetermined"};
  }
  const AnyCamera camera = AnyCamera::make(model_id, state.params);
  for (std::size_t v = 0; v < views.size(); ++v) {
    for (const Observation& observation : views[v]) {
      if (!camera.project(state.camera_from_board[v] * observation.p_board).ok())
        return Unsoundness{.id = "corners_outside_domain", .text = "it cannot see all of the corners"};
    }
  }
  const DomainCertificate domain = certifyDomain(camera, size);
  if (!foldsInsideImage(domain)) return std::nullopt;
  return Unsoundness{.id = "folds_in_image",
                     .text = "it folds over inside the image, " +
                             numberText("%.0f", domain.cone.max_angle_rad * 180 / std::numbers::pi) +
                             " degrees from the axis",
                     .folds = true};
}

}  // namespace alidade
