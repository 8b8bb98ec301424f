// SPDX-License-Identifier: MIT
#include "alidade/adjust/scene/scene_fit.h"

#include <cmath>
#include <limits>

namespace alidade {

ErrorField::Basis ErrorField::basisAt(const Eigen::Vector2d& pixel, const ImageSize& size) {
  const double x = (2 * pixel.x() + 1) / size.width - 1;
  const double y = (2 * pixel.y() + 1) / size.height - 1;
  Basis basis;
  basis << 1, x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y;
  return basis;
}

PointInCamera inCamera(const SE3& camera_from_world, const Eigen::Vector4d& point) {
  const Eigen::Matrix3d R = camera_from_world.rotation.matrix();
  PointInCamera p;
  p.J_point << R, camera_from_world.translation;
  p.at = p.J_point * point;
  p.J_pose << R * point.w(), -R * hat(point.head<3>());
  return p;
}

SceneProjection projectSighting(const SceneFit& fit, const SceneSighting& sighting, bool wants_params) {
  SceneProjection result;
  const PointInCamera p = inCamera(fit.camera_from_world[sighting.frame], fit.points[sighting.point]);
  const auto num_params = static_cast<Eigen::Index>(wants_params ? fit.camera.parameters().size() : 0);
  Eigen::Matrix<double, 2, 3, Eigen::RowMajor> J_px_cam;
  Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor, 2, 24> J_params(2, num_params);
  const Projection projection =
      fit.camera.project(p.at, J_px_cam.data(), wants_params ? J_params.data() : nullptr);
  if (!projection.ok()) return result;
  result.ok = true;
  result.error = projection.pixel + fit.readout * sighting.readout_px - sighting.pixel;
  result.J_pose = J_px_cam * p.J_pose;
  result.J_point = J_px_cam * p.J_point;
  result.J_params = J_params;
  if (fit.field_px > 0) {
    result.field = ErrorField::basisAt(sighting.pixel, fit.size);
    result.error += ErrorField::at(result.field, fit.fields[sighting.frame]);
  }
  return result;
}

Eigen::Vector2d sightingError(const SceneFit& fit, const SceneSighting& sighting) {
  // Rounded as in projectSighting(), which must have a pixel where this has one.
  const Projection projection =
      fit.camera.project(inCamera(fit.camera_from_world[sighting.frame], fit.points[sighting.point]).at);
  Eigen::Vector2d error = projection.pixel + fit.readout * sighting.readout_px - sighting.pixel;
  if (fit.field_px > 0)
    error += ErrorField::at(ErrorField::basisAt(sighting.pixel, fit.size), fit.fields[sighting.frame]);
  return error;
}

double sceneCost(const SceneFit& fit) {
  double cost = 0;
  for (const SceneSighting& sighting : fit.sightings)
    cost += 0.5 * fit.loss.rho((sightingError(fit, sighting) / sighting.sigma_px).squaredNorm());
  if (fit.field_px > 0) {
    for (const ErrorField::Coefficients& field : fit.fields)
      cost += 0.5 * field.squaredNorm() / (fit.field_px * fit.field_px);
  }
  return std::isfinite(cost) ? cost : std::numeric_limits<double>::infinity();
}

}  // namespace alidade
