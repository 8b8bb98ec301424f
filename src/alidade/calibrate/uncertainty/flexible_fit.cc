// SPDX-License-Identifier: MIT
#include "alidade/calibrate/uncertainty/flexible_fit.h"

#include "alidade/camera/model_fit.h"

namespace alidade {

bool isStiff(std::string_view model_id) {
  return model_id == "fov" || model_id == "ucm" || model_id == "eucm" || model_id == "double_sphere";
}

std::optional<Fit> flexibleFit(const Fit& fit) {
  const FitCamera& camera = onlyCamera(fit);
  const bool is_stiff = isStiff(camera.model);
  if (!is_stiff && camera.model != "pinhole" && camera.model != "radtan") return std::nullopt;
  Fit flexible = fit;
  FitCamera& of = onlyCamera(flexible);
  of.model = is_stiff ? "kannala_brandt" : "rational";
  const AnyCamera same = fitModel(AnyCamera::make(camera.model, camera.params), camera.size, of.model).camera;
  of.params.assign(same.parameters().begin(), same.parameters().end());
  of.constraint = {};
  of.weak_prior = {};
  return flexible;
}

}  // namespace alidade
