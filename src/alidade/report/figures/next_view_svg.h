// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>

#include "alidade/calibrate/calibrator.h"
#include "alidade/guide/guidance.h"
#include "alidade/target/board.h"
#include "alidade/target/view.h"

namespace alidade {

/// A drawing (SVG) of the image: the corners that the calibration used, the projection uncertainty as a
/// coarse colour map (omitted if undetermined), and the next position of the board, with marks on the sides
/// that are nearer to the camera.
/// @param views  as given to the calibration
[[nodiscard]] std::string nextViewSvg(const Calibration& calibration, std::span<const View> views,
                                      const Guidance& guidance);

}  // namespace alidade
