// SPDX-License-Identifier: MIT
#include "alidade/calibrate/uncertainty/far_difference.h"

#include <limits>

#include "alidade/geometry/rotation_conversions.h"

namespace alidade {
std::vector<double> farDifferences(const AnyCamera& a, const AnyCamera& b,
                                   std::span<const Eigen::Vector2d> pixels,
                                   std::span<const Eigen::Vector2d> anchors) {
  Eigen::Matrix3d correlation = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector2d& pixel : anchors) {
    const auto ray_a = a.unproject(pixel);
    const auto ray_b = b.unproject(pixel);
    if (ray_a && ray_b) correlation += ray_b->normalized() * ray_a->normalized().transpose();
  }
  const SO3 b_from_a = bestRotation(correlation);
  std::vector<double> differences;
  differences.reserve(pixels.size());
  for (const Eigen::Vector2d& pixel : pixels) {
    double& difference = differences.emplace_back(std::numeric_limits<double>::quiet_NaN());
    const auto ray = a.unproject(pixel);
    if (!ray) continue;
    const Projection projection = b.project(b_from_a * *ray);
    if (projection.ok()) difference = (projection.pixel - pixel).norm();
  }
  return differences;
}

}  // namespace alidade
