// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"

namespace alidade {

/// A point of the camera frame (metres) and its pixel, kept in a camera file so that whoever reads the file
/// can tell whether he understands it as its writer did.
struct SelfCheckPoint {
  Eigen::Vector3d point;
  Eigen::Vector2d pixel;
};

/// What a camera file claims about its own domain.
struct DomainClaim {
  double max_angle_rad = 0;
  bool full_image = false;
};

/// Points that project all over the image (centre, corners, edges), at several depths. Pixels without a ray
/// are left out.
[[nodiscard]] std::vector<SelfCheckPoint> makeSelfCheck(const AnyCamera& camera, ImageSize size);

}  // namespace alidade
