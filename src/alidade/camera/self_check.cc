// SPDX-License-Identifier: MIT
#include "alidade/camera/self_check.h"

#include <cmath>
#include <limits>

namespace alidade {

std::vector<SelfCheckPoint> makeSelfCheck(const AnyCamera& camera, ImageSize size) {
  std::vector<SelfCheckPoint> points;
  double depth = 0.5;
  for (const double y : {0.02, 0.5, 0.98}) {
    for (const double x : {0.02, 0.5, 0.98}) {
      const auto ray = camera.unproject({x * (size.width - 1), y * (size.height - 1)});
      depth += 0.25;
      if (!ray) continue;
      // Rounded, so that the file stays readable; the pixel is computed from exactly what is written.
      const Eigen::Vector3d point = (depth * *ray * 1e4).array().round() / 1e4;
      const Projection projection = camera.project(point);
      if (projection.ok()) points.push_back({point, projection.pixel});
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
    const bool is_inside = (point.pixel.array() > -0.5 - kSelfCheckPx).all() &&
                           (point.pixel.array() < side - 0.5 + kSelfCheckPx).all();
    if (!is_inside && !outcome.outside_image) outcome.outside_image = i;
    const Projection projection = camera.project(point.point);
    const double off =
        projection.ok() ? (projection.pixel - point.pixel).norm() : std::numeric_limits<double>::infinity();
    if (off <= outcome.worst_px) continue;
    outcome.worst = i;
    outcome.worst_px = off;
  }
  return outcome;
}

}  // namespace alidade
