// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "alidade/detect/board/detection.h"
#include "alidade/target/board.h"

// Several boards in one set of images.

namespace alidade {

/// Checks that images can distinguish the boards: by their markers, or by the counts of their corners.
/// @throws Error (kUsage) naming two boards that look alike, and the remedy
void requireDistinguishable(std::span<const Board> boards);

/// Resolves conflicts in which two boards claim the same corners of one image: the corners of the losing
/// board are withdrawn (kUnplaced). Markers are certain; without them, a complete board wins over a part of a
/// board, and of two parts neither is kept.
/// @param outcomes  of the same images, one list for each board
void settleClaims(std::span<const Board> boards, std::span<std::vector<ImageOutcome>> outcomes);

}  // namespace alidade
