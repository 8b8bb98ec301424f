// SPDX-License-Identifier: MIT
#include "alidade/calibrate/uncertainty/flexible_fit.h"

#include "alidade/camera/model_fit.h"
#include "alidade/camera/model_traits.h"

namespace alidade {

std::optional<Fit> flexibleFit(const Fit& fit) {
  const FitCamera& camera = onlyCamera(fit);
  const std::string_view flexible_id = modelTraits(camera.model).flexible_id;
  if (flexible_id.empty()) return std::nullopt;
  Fit flexible = fit;
  FitCamera& of = onlyCamera(flexible);
  of.model = flexible_id;
  const AnyCamera same = fitModel(AnyCamera::make(camera.model, camera.params), camera.size, of.model).camera;
  of.params.assign(same.parameters().begin(), same.parameters().end());
  of.constraint = {};
  of.weak_prior = {};
  return flexible;
}

}  // namespace alidade
