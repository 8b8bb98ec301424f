// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <optional>

#include <Eigen/Core>

#include "alidade/core/image.h"

namespace alidade {

/// The side of a dark marker as a share of the bright square around it, from the positions where grey values
/// are midway between those of the square and those of the marker's border. Nothing if the margin between
/// them is too narrow or too faint.
/// @param square  the corners of the square, pixels, in either sense of rotation
/// @param expected  the share, accurate to a tenth of its value
/// @param num_cells  cells of the marker along a side, including its border
[[nodiscard]] std::optional<double> measuredMarkerShare(const GrayImage& image,
                                                        const std::array<Eigen::Vector2d, 4>& square,
                                                        double expected, int num_cells);

}  // namespace alidade
