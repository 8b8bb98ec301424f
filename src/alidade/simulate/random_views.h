// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "alidade/camera/any_camera.h"
#include "alidade/core/image.h"
#include "alidade/core/random.h"
#include "alidade/geometry/se3.h"
#include "alidade/record/scene.h"
#include "alidade/target/board.h"

namespace alidade {

/// Poses (camera_from_board) of a board that is fully visible: all its squares, including the outermost,
/// project into the image.
///
/// The centre of the squares appears at a pixel that is uniformly distributed over the image. From the pose
/// that faces the camera along the ray through that pixel, the board is tilted about a random axis of its
/// plane and turned about its normal. Tilts count from that ray and not from the optical axis, so that
/// foreshortening is limited all over a wide image. They are uniformly distributed over the disc of tilts
/// (two thirds of the largest on average), since views without tilt say little about the focal length. A fill
/// at which `max_attempts` placements fail is reduced by a fifth, even below `min_fill`.
///
///
/// @throws Error (kInput) if an option is out of range, or no view fits even with a fill of a hundredth.
[[nodiscard]] std::vector<SE3> randomViews(const AnyCamera& camera, ImageSize size, const Board& board,
                                           int count, Random& random, const RandomViewOptions& options = {});

}  // namespace alidade
