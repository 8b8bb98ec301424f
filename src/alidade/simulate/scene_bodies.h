// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "alidade/geometry/se3.h"
#include "alidade/record/footage_scene.h"
#include "alidade/simulate/footage_motion.h"

namespace alidade {

/// A textured body of the simulated surroundings. Times are counted in frames.
struct SceneBody {
  enum class Shape {
    kBox,    ///< seen from outside
    kRoom,   ///< a box seen from inside
    kPlane,  ///< the infinite plane z = 0, seen from z < 0
  };
  Shape shape = Shape::kBox;
  Eigen::Vector3d half_size = Eigen::Vector3d::Ones();  ///< metres; of boxes and rooms
  SE3 world_from_body = {};                             ///< resting pose, at time 0
  std::uint32_t seed = 0;                               ///< of the texture
  double texture_scale = 1;                             ///< 2: all details are twice as large
  bool is_moving = false;
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< metres per frame, in the world
  SmoothCurve wander = {};  ///< displacement over time, in the body frame at rest, metres
  SmoothCurve turn = {};    ///< rotation vector over time, in the body frame at rest

  [[nodiscard]] SE3 worldFromBodyAt(double time_frames) const;
};

/// A body as one camera sees it at one time.
struct BodyView {
  Eigen::Matrix3d body_from_camera;  ///< rotation part
  Eigen::Vector3d camera_in_body;
  Eigen::Vector3d axis;   ///< of a cone, in the camera frame, that holds the whole body
  double cos_angle = -1;  ///< of the cone; slightly too small, so that neighbouring rows can share it
};

/// All bodies as seen by a camera at a time.
[[nodiscard]] std::vector<BodyView> viewBodies(const std::vector<SceneBody>& bodies,
                                               const SE3& camera_from_world, double time_frames);

/// The first hit of a ray on a surface.
struct SurfaceHit {
  double distance_m = 0;
  double cos_incidence = 1;  ///< cosine of the angle between the ray and the surface's normal
  int body = -1;             ///< index; -1: no hit
  int face = 0;              ///< of the body, 0 to 5
  Eigen::Vector2d on_face = Eigen::Vector2d::Zero();  ///< metres
};

/// `ray` is a unit vector in the camera frame. With a share above 0, the views are interpolated linearly
/// between `views` and `next_views`, which must be close to each other.
[[nodiscard]] SurfaceHit castRay(const std::vector<SceneBody>& bodies, const std::vector<BodyView>& views,
                                 const std::vector<BodyView>& next_views, double share,
                                 const Eigen::Vector3d& ray);

/// All bodies at rest. `travel_m`: length of a straight path.
[[nodiscard]] std::vector<SceneBody> stillBodies(const FootageScene& scene, double travel_m);

/// The moving objects; `scale` multiplies their size as far as there is room. They keep clear of the camera,
/// but not of each other or of boxes. `focal_px`: pixels per radian at the image centre.
[[nodiscard]] std::vector<SceneBody> movingBodies(const FootageScene& scene, const FootageMotion& motion,
                                                  const std::vector<SceneBody>& still, double focal_px,
                                                  double scale);

}  // namespace alidade
