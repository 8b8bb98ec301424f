// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/camera/camera.h"
#include "alidade/camera/model_list.h"

namespace alidade::detail {

/// What AnyCamera holds, for the library's own loops: programs need neither the models nor the time that it
/// takes to compile them.
struct CameraVariant {
  // Implicit, so that AnyCamera takes a camera of any model.
  template <class M>
  CameraVariant(const Camera<M>& of_model) : camera(of_model) {}

  AllModels::Variant<Camera> camera;
};

}  // namespace alidade::detail
