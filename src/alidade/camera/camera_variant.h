// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/camera/camera.h"
#include "alidade/camera/model_list.h"

namespace alidade::detail {

/// Content of AnyCamera, for the library's own loops. It is hidden because programs need neither the models
/// nor the time to compile them.
struct CameraVariant {
  // Implicit, so that AnyCamera takes a camera of any model.
  template <class M>
  CameraVariant(const Camera<M>& of_model) : camera(of_model) {}

  AllModels::Variant<Camera> camera;
};

}  // namespace alidade::detail
