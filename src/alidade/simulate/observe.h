// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "alidade/camera/any_camera.h"
#include "alidade/core/image.h"
#include "alidade/core/random.h"
#include "alidade/geometry/se3.h"
#include "alidade/target/board.h"
#include "alidade/target/view.h"

namespace alidade {

/// Exact pixels of the corners of a board; for circle grids, the centroids of the images of the discs that
/// are fully visible. Corners that do not project, or project outside [-0.5, width - 0.5) x [-0.5, height -
/// 0.5), are left out; from behind, a board shows none. Corner::sigma_px stays unknown.
[[nodiscard]] View exactView(const AnyCamera& camera, ImageSize size, const Board& board,
                             const SE3& camera_from_board, std::string image_name);

/// Moves each corner by independent normal noise of standard deviation `sigma_px` along each axis, which may
/// carry it across the image's border, and writes `sigma_px` to the corners.
/// @throws Error (kInput) if `sigma_px` is negative or not finite.
void addCornerNoise(View& view, double sigma_px, Random& random);

}  // namespace alidade
