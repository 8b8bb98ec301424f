// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"
#include "alidade/core/image.h"
#include "alidade/core/random.h"
#include "alidade/footage/geometry/two_view.h"
#include "alidade/geometry/se3.h"

namespace alidade::testing {

/// A camera of each kind that the tests of footage look through, for images of 640x480.
inline std::vector<AnyCamera> footageCameras() {
  return {
      AnyCamera::make("pinhole", std::vector<double>{500, 502, 322, 238}),
      AnyCamera::make("radtan", std::vector<double>{520, 521, 318, 243, -0.28, 0.09, 0.001, -0.0005, 0.0}),
      AnyCamera::make("kannala_brandt", std::vector<double>{205, 205.5, 321, 239, 0.01, -0.004, 0.001, 0.0}),
      AnyCamera::make("double_sphere", std::vector<double>{190, 190, 320, 240, -0.2, 0.55})};
}

inline constexpr ImageSize kFootageSize{640, 480};

/// Points at 2 to 6 m in all directions that the pixels of an image have, by an even spread of pixels.
struct ScatteredPoints {
  std::vector<Eigen::Vector2d> pixels;
  std::vector<Eigen::Vector3d> points;
};

inline ScatteredPoints scatteredPoints(const AnyCamera& camera, std::size_t count, Random& random,
                                       double near_m = 2, double far_m = 6) {
  ScatteredPoints result;
  while (result.points.size() < count) {
    const Eigen::Vector2d pixel(random.uniform(0, kFootageSize.width - 1),
                                random.uniform(0, kFootageSize.height - 1));
    const auto ray = camera.unproject(pixel);
    if (!ray) continue;
    result.pixels.push_back(pixel);
    result.points.push_back(random.uniform(near_m, far_m) * *ray);
  }
  return result;
}

inline bool isInFootage(const Eigen::Vector2d& pixel) {
  return pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() <= kFootageSize.width - 1 &&
         pixel.y() <= kFootageSize.height - 1;
}

inline Eigen::Vector2d noisy(const Eigen::Vector2d& pixel, double sigma_px, Random& random) {
  return pixel + sigma_px * Eigen::Vector2d(random.normal(), random.normal());
}

inline Eigen::Vector3d randomDirection(Random& random) {
  return Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized();
}

inline double angleDeg(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return 180 / std::numbers::pi * std::atan2(a.cross(b).norm(), a.dot(b));
}

}  // namespace alidade::testing
