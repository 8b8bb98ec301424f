// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"

namespace alidade {

/// Points along the outer edges of an image's outer pixels, a pixel apart.
[[nodiscard]] std::vector<Eigen::Vector2d> imageBorder(ImageSize size);

/// foldsInsideImage() of certifyDomain(), which costs more.
[[nodiscard]] bool foldsInsideImage(const AnyCamera& camera, ImageSize size);

}  // namespace alidade
