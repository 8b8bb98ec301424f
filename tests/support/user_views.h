// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "alidade/core/random.h"
#include "alidade/geometry/se3.h"
#include "alidade/target/board_kinds.h"
#include "alidade/target/view.h"
#include "support/lens_draw.h"

namespace alidade {

/// Views of a board by a camera, with the truth.
struct UserSet {
  Checkerboard board;
  std::vector<SE3> poses;  ///< camera_from_board of each view
  std::vector<View> views;
};

/// Views as someone takes them who has read the advice: all over the image circle, tilted by 20 to 50 degrees
/// against the line of sight about any axis, any roll up to 30 degrees, near and far. A board may stick out
/// of the image, as long as a third of its corners are seen.
[[nodiscard]] UserSet drawUserViews(const DrawnCamera& drawn, int count, double noise_px, Random& random);

}  // namespace alidade
