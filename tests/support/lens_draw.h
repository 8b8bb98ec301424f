// SPDX-License-Identifier: MIT
#pragma once

#include <string_view>

#include "alidade/camera/any_camera.h"
#include "alidade/core/image.h"
#include "alidade/core/random.h"

namespace alidade {

/// A camera as someone might own it, and the cone that its lens fills.
struct DrawnCamera {
  AnyCamera camera;
  ImageSize size;
  double rim_rad = 0;  ///< the image circle: no light comes from beyond this angle
};

/// Draws a camera whose longer side spans `fov_deg`: the lens' shape at random within what such lenses have,
/// the principal point up to 5 % of each side off the centre, pixels up to 1 % from square, one of a few
/// common image sizes. Up to 140 degrees the lens lights the whole image and does not fold in it; beyond, its
/// image circle is as wide as the longer side.
[[nodiscard]] DrawnCamera drawCamera(std::string_view model_id, double fov_deg, Random& random);

}  // namespace alidade
