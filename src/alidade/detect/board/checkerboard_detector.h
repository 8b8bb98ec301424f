// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/core/image.h"
#include "alidade/detect/board/detection.h"
#include "alidade/target/checkerboard.h"

namespace alidade {

/// Finds a whole or partly visible checkerboard in a grey image and refines its corners (CornerFitter). The
/// search uses reduced resolutions, the refinement the full one. For an unambiguous board, the ids refer to
/// the same physical corners in every view: in the image, the rows (y) run a quarter turn clockwise from the
/// columns (x), and the inner square at corner 0 is dark. For an ambiguous board, the columns run to the
/// right in the image, or downwards if they are steeper than 45 degrees.
[[nodiscard]] Detection findBoard(const GrayImage& image, const Checkerboard& board);

}  // namespace alidade
