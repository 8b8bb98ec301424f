// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"
#include "alidade/geometry/se3.h"
#include "alidade/target/checkerboard.h"
#include "alidade/target/view.h"

namespace alidade {

/// camera_from_board from a homography board plane -> normalised plane (pixels with the camera taken out):
/// its columns are r1, r2 and t up to scale; the rotation is the nearest orthonormal one (Zhang 2000,
/// section 3.1 and appendix C). Nothing if the board would pass through the camera centre.
[[nodiscard]] std::optional<SE3> poseFromHomography(const Eigen::Matrix3d& plane_from_board);

/// Pose of the board in a view: the corners' rays through `camera`, then the homography to the plane z = 1.
/// Nothing where too few corners have a ray in front of the camera or they do not determine a pose.
[[nodiscard]] std::optional<SE3> poseFromView(const AnyCamera& camera, const Checkerboard& board,
                                              std::span<const Corner> corners);

}  // namespace alidade
