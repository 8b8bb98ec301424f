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
/// coarse map of colours (left out where it is not determined), and where the board goes next, with the sides
/// marked that are nearer to the camera.
/// @param views  those that were given to the calibration
[[nodiscard]] std::string nextViewSvg(const Calibration& calibration, std::span<const View> views,
                                      const Guidance& guidance);

}  // namespace alidade
