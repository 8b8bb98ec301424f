// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace alidade {

/// Points as a PLY file in text form (Turk 1994) with the properties x, y, z and piece.
/// @param comments  lines at the top
/// @param pieces    points in the world of each piece; pieces count from 1
[[nodiscard]] std::string pointCloudText(std::span<const std::string> comments,
                                         std::span<const std::vector<Eigen::Vector3d>> pieces);

}  // namespace alidade
