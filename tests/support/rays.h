// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

#include "alidade/core/image.h"

namespace alidade {

/// The image size of the cameras of model_fixture.h.
inline constexpr ImageSize kTestImage{.width = 1920, .height = 1200};

/// Unit ray at an angle from the optical axis, in the direction `azimuth` from x towards y.
inline Eigen::Vector3d rayAt(double angle, double azimuth) {
  return {std::sin(angle) * std::cos(azimuth), std::sin(angle) * std::sin(azimuth), std::cos(angle)};
}

/// Angle between two unit vectors, exact for small ones.
inline double angleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return 2 * std::asin(std::min(1.0, 0.5 * (a - b).norm()));
}

}  // namespace alidade
