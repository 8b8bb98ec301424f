// SPDX-License-Identifier: MIT
#include "alidade/simulate/footage_frame.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/LU>

namespace alidade {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

Vector2d transformed(const Matrix3d& homography, const Vector2d& p) {
  const Vector3d q = homography * p.homogeneous();
  if (!(q.z() > 0)) return Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
  return q.hnormalized();
}

bool isInPicture(const Vector2d& p, ImageSize size) {
  return p.x() >= -0.5 && p.x() < size.width - 0.5 && p.y() >= -0.5 && p.y() < size.height - 0.5;
}

}  // namespace

Vector2d focalAtCentre(const AnyCamera& camera) {
  double J_px_cam[6];
  if (!camera.project(Vector3d::UnitZ(), J_px_cam).ok())
    return {camera.parameter("fx"), camera.parameter("fy")};
  return {J_px_cam[0], J_px_cam[4]};
}

FootageFrame::FootageFrame(const FootageScene& scene, const AnyCamera& camera, const FootageMotion& motion,
                           const std::vector<SceneBody>& bodies, int index)
    : scene_(scene),
      camera_(camera),
      motion_(motion),
      bodies_(bodies),
      index_(index),
      is_stabilised_(scene.effects.stabilisation_frames > 0),
      picture_from_sensor_(Matrix3d::Identity()),
      sensor_from_picture_(Matrix3d::Identity()),
      views_(viewsAt(index)) {
  if (!is_stabilised_) return;
  correction_ = motion.smoothRotation(index, scene.effects.stabilisation_frames) *
                motion.pose(index).rotation.inverse();
  const Vector2d focal = focalAtCentre(camera_);
  Matrix3d K;
  K << focal.x(), 0, camera_.parameter("cx"),  //
      0, focal.y(), camera_.parameter("cy"),   //
      0, 0, 1;
  picture_from_sensor_ = K * correction_.matrix() * K.inverse();
  sensor_from_picture_ = K * correction_.inverse().matrix() * K.inverse();
}

double FootageFrame::timeOfRow(double sensor_row) const {
  const double height = scene_.image_size.height;
  return index_ + scene_.effects.rolling_shutter * (sensor_row - 0.5 * (height - 1)) / height;
}

Vector2d FootageFrame::toSensor(const Vector2d& picture) const {
  return is_stabilised_ ? transformed(sensor_from_picture_, picture) : picture;
}

Vector2d FootageFrame::toPicture(const Vector2d& sensor) const {
  return is_stabilised_ ? transformed(picture_from_sensor_, sensor) : sensor;
}

std::vector<BodyView> FootageFrame::viewsAt(double time_frames) const {
  return viewBodies(bodies_, motion_.pose(time_frames), time_frames);
}

SurfaceHit FootageFrame::look(const Vector2d& picture) const {
  const Vector2d sensor = toSensor(picture);
  if (!sensor.allFinite()) return {};
  const auto ray = camera_.unproject(sensor);
  if (!ray) return {};
  if (scene_.effects.rolling_shutter == 0) return castRay(bodies_, views_, views_, 0, *ray);
  const auto views = viewsAt(timeOfRow(sensor.y()));
  return castRay(bodies_, views, views, 0, *ray);
}

std::optional<FootageFrame::Sighting> FootageFrame::sight(int body, const Vector3d& in_body) const {
  // The row determines the time, which determines the row. The iteration is a contraction unless points move
  // by about the height of the image per frame.
  constexpr int kMaxIterations = 60;
  constexpr double kTolerancePx = 1e-10;
  const SceneBody& owner = bodies_[static_cast<std::size_t>(body)];
  double row = 0.5 * (scene_.image_size.height - 1);
  for (int i = 0; i < kMaxIterations; ++i) {
    const double time = timeOfRow(row);
    const Vector3d in_camera = motion_.pose(time) * (owner.worldFromBodyAt(time) * in_body);
    const Projection projection = camera_.project(in_camera);
    if (!projection.ok()) return std::nullopt;
    const double change = std::abs(projection.pixel.y() - row);
    row = projection.pixel.y();
    if (scene_.effects.rolling_shutter == 0 || change < kTolerancePx)
      return Sighting{projection.pixel, in_camera, time};
  }
  return std::nullopt;
}

std::optional<Vector2d> FootageFrame::project(int body, const Vector3d& in_body) const {
  const auto sighting = sight(body, in_body);
  if (!sighting) return std::nullopt;
  const Vector2d picture = toPicture(sighting->sensor);
  if (!picture.allFinite()) return std::nullopt;
  return picture;
}

std::optional<Vector2d> FootageFrame::see(int body, const Vector3d& in_body) const {
  const auto sighting = sight(body, in_body);
  if (!sighting) return std::nullopt;
  const Vector2d picture = toPicture(sighting->sensor);
  if (!picture.allFinite() || !isInPicture(picture, scene_.image_size)) return std::nullopt;
  // The point is on a surface, so the first hit of its ray is the point itself, up to rounding, or hides it.
  constexpr double kRounding = 1e-7;
  const double distance = sighting->in_camera.norm();
  const Vector3d ray = sighting->in_camera / distance;
  const auto hit = [&](const std::vector<BodyView>& views) { return castRay(bodies_, views, views, 0, ray); };
  const SurfaceHit first =
      scene_.effects.rolling_shutter == 0 ? hit(views_) : hit(viewsAt(sighting->time_frames));
  if (first.distance_m < (1 - kRounding) * distance) return std::nullopt;
  return picture;
}

}  // namespace alidade
