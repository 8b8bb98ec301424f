// SPDX-License-Identifier: MIT
#include "alidade/camera/self_check.h"

#include <cmath>

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

}  // namespace alidade
