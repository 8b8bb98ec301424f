// SPDX-License-Identifier: MIT
// A test harness that only projects points, compiled without CMake.
#include "alidade/camera.h"

#include <vector>

int main() {
  const auto camera = alidade::AnyCamera::make("pinhole", std::vector<double>{800, 820, 319.5, 239.5});
  const alidade::Projection projection = camera.project({0.2, -0.1, 2.0});
  return projection.ok() && (projection.pixel - Eigen::Vector2d(399.5, 198.5)).norm() < 1e-9 ? 0 : 1;
}
