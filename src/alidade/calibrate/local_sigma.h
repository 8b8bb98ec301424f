// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "alidade/calibrate/observation.h"
#include "alidade/target/checkerboard.h"

namespace alidade {

/// Standard deviation of the coordinate of a corner of weight 1, px, from the differences of the errors of
/// corners that are neighbours on the board (von Neumann 1941, Distribution of the ratio of the mean square
/// successive difference to the variance). Noise that is independent from corner to corner gives the same as
/// the errors themselves; errors that vary smoothly give much less. NaN where no two neighbours were seen.
/// @param views  the corners in use; @param errors  one a corner, px, not weighted, in the same order
[[nodiscard]] double localSigma(const Checkerboard& board, std::span<const std::vector<Observation>> views,
                                std::span<const std::vector<Eigen::Vector2d>> errors);

}  // namespace alidade
