// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/core/image.h"
#include "alidade/detect/board/detection.h"
#include "alidade/target/april_grid.h"

namespace alidade {

/// Finds an AprilGrid whose tags have any of AprilGrid::kBorders, black on white or white on black. Tags with
/// other ids belong to other boards.
[[nodiscard]] Detection findBoard(const GrayImage& image, const AprilGrid& board);

}  // namespace alidade
