// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "alidade/detect/board/detection.h"
#include "alidade/target/board.h"

// Several boards in one set of images.

namespace alidade {

/// Checks that images can tell the boards apart: by their markers, or by the counts of their corners.
/// @throws Error (kUsage) naming two boards that look alike, and what to do
void requireDistinguishable(std::span<const Board> boards);

/// Decides where two boards claim the same corners of one image, and withdraws those of the other board
/// (kUnplaced). Markers are certain; without them, a whole board takes precedence over a part of one, and of
/// two parts neither is kept.
/// @param outcomes  of the same images, one list for each board
void settleClaims(std::span<const Board> boards, std::span<std::vector<ImageOutcome>> outcomes);

}  // namespace alidade
