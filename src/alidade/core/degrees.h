// SPDX-License-Identifier: MIT
#pragma once

#include <numbers>

namespace alidade {

// Angles are in radians everywhere except in texts for people.

inline constexpr double kDegPerRad = 180 / std::numbers::pi;
inline constexpr double kRadPerDeg = std::numbers::pi / 180;

}  // namespace alidade
