// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/core/image.h"
#include "alidade/detect/board/detection.h"
#include "alidade/target/charuco_board.h"

namespace alidade {

/// Finds a ChArUco board of either layout, dark on white or white on dark. Ids of corners follow from the
/// markers around them.
[[nodiscard]] Detection findBoard(const GrayImage& image, const CharucoBoard& board);

}  // namespace alidade
