// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "alidade/adjust/observation.h"
#include "alidade/camera/any_camera.h"
#include "alidade/core/image.h"
#include "alidade/geometry/se3.h"
#include "alidade/target/checkerboard.h"

namespace alidade {

/// A view that someone could take.
struct ViewCandidate {
  SE3 camera_from_board;
  /// Some of the corners that would be seen, evenly over the board, at the pixels where the camera puts them;
  /// their weights sum to the number of all that would be seen.
  std::vector<Observation> corners;
  bool is_whole = false;  ///< all corners would be seen
};

/// What a user can do.
struct CandidateLimits {
  double nearest_m = 0;  ///< distances of the board's middle
  double farthest_m = 0;
  bool is_upright = false;  ///< the board is held with its columns along the image's height
};

/// Poses of a board all over the image: its middle at places 7 x 5 (along the longer and the shorter side),
/// at three distances within the limits, spanning 30, 60 and 95 % of the image's smaller side without tilt,
/// and tilted by 0, 20 or 40 degrees to each side. At least half of the corners lie inside the image, with a
/// margin of a fiftieth of its smaller side, on squares of which none appears narrower than 6 pixels, and
/// none are seen from less than 15 degrees above the board. A board of which a part lies outside shows at
/// least one side from end to end, by which detection tells the part. In an order that depends on the
/// arguments alone.
[[nodiscard]] std::vector<ViewCandidate> viewCandidates(const AnyCamera& camera, ImageSize size,
                                                        const Checkerboard& board,
                                                        const CandidateLimits& limits);

}  // namespace alidade
