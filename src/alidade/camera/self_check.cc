// SPDX-License-Identifier: MIT
#include "alidade/camera/self_check.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace alidade {

namespace {

// Rounded to the coarsest of several steps that keeps the point near `pixel`, so that a file stays readable;
// with a long focal length, 0.1 mm may be many pixels. The pixel is computed from exactly the written
// numbers.
std::optional<SelfCheckPoint> checkPointNear(const AnyCamera& camera, ImageSize size,
                                             const Eigen::Vector3d& exact, const Eigen::Vector2d& pixel) {
  constexpr double kShareOfSide = 0.01;  // outermost points are two such steps from the border
  for (const double steps_per_m : {1e4, 1e6, 1e8}) {
    const Eigen::Vector3d point = (exact * steps_per_m).array().round() / steps_per_m;
    const Projection projection = camera.projectPoint(point);
    const bool is_near =
        ((projection.pixel - pixel).array().abs() <= kShareOfSide * Eigen::Array2d(size.width, size.height))
            .all();
    if (projection.ok() && is_near) return SelfCheckPoint{point, projection.pixel};
  }
  const Projection projection = camera.projectPoint(exact);
  if (!projection.ok()) return std::nullopt;
  return SelfCheckPoint{exact, projection.pixel};
}

}  // namespace

std::vector<SelfCheckPoint> makeSelfCheck(const AnyCamera& camera, ImageSize size) {
  std::vector<SelfCheckPoint> points;
  double depth = 0.5;
  for (const double y : {0.02, 0.5, 0.98}) {
    for (const double x : {0.02, 0.5, 0.98}) {
      const Eigen::Vector2d pixel(x * (size.width - 1), y * (size.height - 1));
      const auto ray = camera.unproject(pixel);
      depth += 0.25;
      if (!ray) continue;
      if (const auto point = checkPointNear(camera, size, camera.startOf(*ray) + depth * *ray, pixel))
        points.push_back(*point);
    }
  }
  return points;
}

SelfCheckOutcome runSelfCheck(const AnyCamera& camera, ImageSize size,
                              std::span<const SelfCheckPoint> points) {
  SelfCheckOutcome outcome;
  const Eigen::Array2d side(size.width, size.height);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const SelfCheckPoint& point = points[i];
    // Earlier versions rounded every point to a tenth of a millimetre, regardless of the effect in pixels.
    constexpr double kRounding = 1e-4;
    const double slack = kSelfCheckPx + kRounding * std::max(camera.parameters()[0], camera.parameters()[1]) /
                                            point.point.norm();
    const bool is_inside =
        (point.pixel.array() > -0.5 - slack).all() && (point.pixel.array() < side - 0.5 + slack).all();
    if (!is_inside && !outcome.outside_image) outcome.outside_image = i;
    const Projection projection = camera.projectPoint(point.point);
    const double off =
        projection.ok() ? (projection.pixel - point.pixel).norm() : std::numeric_limits<double>::infinity();
    if (off <= outcome.worst_px) continue;
    outcome.worst = i;
    outcome.worst_px = off;
  }
  return outcome;
}

}  // namespace alidade
