// SPDX-License-Identifier: MIT
#pragma once

#include <string_view>
#include <vector>

#include "alidade/core/random.h"
#include "support/lens_draw.h"
#include "support/simulated_set.h"

namespace alidade {

/// One standard deviation of an axis of a corner of drawPoorSet(), px.
inline constexpr double kPoorSetNoisePx = 0.1;

/// 4 to 12 views of a 9x6 board, whole and with noise, that are poor in some way: tilted by less than a limit
/// between 10 and 45 degrees, in half of the sets on one side of the image only, all of them small or not.
/// radtan spans 55 to 95 degrees, kannala_brandt 90 to 140.
[[nodiscard]] SimulatedSet drawPoorSet(std::string_view model_id, std::uint64_t seed);

/// Poses of whole boards at random places, distances and tilts up to 45 degrees.
[[nodiscard]] std::vector<SE3> drawOtherViews(const SimulatedSet& set, int count, std::uint64_t seed);

/// The corners of a pose of the board, with noise.
[[nodiscard]] View noisyView(const SimulatedSet& set, const SE3& camera_from_board, const std::string& name,
                             std::uint64_t seed);

}  // namespace alidade
