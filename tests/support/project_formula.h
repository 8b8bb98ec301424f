// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/camera/camera_model.h"

namespace alidade {

/// Pixel of a point of the camera frame by the bare formula; `params` holds fx fy cx cy and the lens. False
/// where the formula has no value. For automatic differentiation too.
template <CameraModel M, class T>
bool projectFormula(const T* params, const T* p_cam, T* px) {
  T m[2];
  if (!M::lens(params + 4, p_cam, m)) return false;
  px[0] = params[0] * m[0] + params[2];
  px[1] = params[1] * m[1] + params[3];
  return true;
}

}  // namespace alidade
