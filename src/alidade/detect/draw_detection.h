// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/core/image.h"
#include "alidade/detect/detection.h"

namespace alidade {

/// The image with what was found drawn on it, for people to look at: a circle and the id of each corner, the
/// lines between neighbours, corner 0 with the directions of columns (red) and rows (green), and the reason
/// and measures as a line of text. Lines and letters grow with the image.
[[nodiscard]] RasterImage drawDetection(const GrayImage& image, const Detection& detection,
                                        const Board& board);

}  // namespace alidade
