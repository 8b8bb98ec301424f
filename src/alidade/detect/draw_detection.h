// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "alidade/core/image.h"
#include "alidade/detect/board/detection.h"

namespace alidade {

/// The image with the detections of each board drawn on it, for visual inspection: a circle and the id of
/// each corner, the lines between neighbours, corner 0 with the directions of columns (red) and rows (green),
/// and the reason and measures as a line of text, which names its board if there are several. Lines and
/// letters grow with the image.
/// @param outcomes  one for each board
[[nodiscard]] RasterImage drawDetections(const GrayImage& image, std::span<const ImageOutcome> outcomes,
                                         std::span<const Board> boards);

}  // namespace alidade
