// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"
#include "alidade/core/cancel.h"
#include "alidade/core/image.h"
#include "alidade/record/footage_scene.h"
#include "alidade/simulate/footage_motion.h"
#include "alidade/simulate/scene_bodies.h"

namespace alidade {

/// The geometry of one frame of footage: the time of each row, and the way pixels of the sensor move to
/// pixels of the picture. It refers to the scene, the motion and the bodies, which must outlive it.
class FootageFrame {
 public:
  /// @param camera  of this frame
  FootageFrame(const FootageScene& scene, const AnyCamera& camera, const FootageMotion& motion,
               const std::vector<SceneBody>& bodies, int index);

  [[nodiscard]] const AnyCamera& camera() const { return camera_; }
  /// Time of a row in frames; `sensor_row` may lie outside the image.
  [[nodiscard]] double timeOfRow(double sensor_row) const;
  [[nodiscard]] bool hasRollingShutter() const { return scene_.effects.rolling_shutter > 0; }
  /// The place on the sensor of a place in the picture; not finite if there is none.
  [[nodiscard]] Eigen::Vector2d toSensor(const Eigen::Vector2d& picture) const;
  /// The rotation virtual_from_camera by which the picture is stabilised.
  [[nodiscard]] const SO3& correction() const { return correction_; }

  /// All bodies as seen at a time.
  [[nodiscard]] std::vector<BodyView> viewsAt(double time_frames) const;
  /// The first hit of the ray of a place in the picture; body -1 if there is no ray or no hit.
  [[nodiscard]] SurfaceHit look(const Eigen::Vector2d& picture) const;
  /// The place in the picture of a point of a body, even if it is hidden. Nothing if there is none.
  [[nodiscard]] std::optional<Eigen::Vector2d> project(int body, const Eigen::Vector3d& in_body) const;
  /// The same, but nothing if it is hidden or outside the image.
  [[nodiscard]] std::optional<Eigen::Vector2d> see(int body, const Eigen::Vector3d& in_body) const;

 private:
  struct Sighting {
    Eigen::Vector2d picture;
    Eigen::Vector3d in_camera;
    double time_frames;
  };
  [[nodiscard]] SurfaceHit cast(double time_frames, const Eigen::Vector3d& ray) const;
  [[nodiscard]] std::optional<Sighting> sight(int body, const Eigen::Vector3d& in_body) const;

  const FootageScene& scene_;
  AnyCamera camera_;
  const FootageMotion& motion_;
  const std::vector<SceneBody>& bodies_;
  int index_;
  bool is_stabilised_;
  SO3 correction_;
  Eigen::Matrix3d picture_from_sensor_ = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d sensor_from_picture_ = Eigen::Matrix3d::Identity();
  std::vector<BodyView> views_;  // at the frame's time
};

/// The picture of a frame. Each pixel has 2 x 2 rays, and its light is the mean of all rays near it, weighted
/// by the blur of the lens and the square of the pixel. The texture has no detail finer than a pixel.
/// @param noise_seed  of this frame
/// @throws Cancelled once `cancel` is set
[[nodiscard]] GrayImage renderFootageFrame(const FootageScene& scene, const std::vector<SceneBody>& bodies,
                                           const FootageFrame& frame, std::uint64_t noise_seed,
                                           const CancelFlag* cancel);

/// Pixels per radian at the place where the optical axis meets the image, along u and v.
[[nodiscard]] Eigen::Vector2d focalAtCentre(const AnyCamera& camera);

}  // namespace alidade
