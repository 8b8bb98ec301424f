// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include <Eigen/Core>

#include "alidade/adjust/board/observation.h"
#include "alidade/adjust/board/view_kernel.h"
#include "alidade/camera/any_camera.h"
#include "alidade/geometry/se3.h"

namespace alidade {

/// camera_from_board from points of the board's plane (metres) and the unit rays on which a central camera
/// sees them, in any direction, including behind the camera. With q = (x, y, 1), a point lies on its ray b if
/// b x (H q) = 0, where H = [r1 r2 t] up to scale: linear in H, solved as the direct linear transform of rays
/// (Hartley and Zisserman, 2nd ed., section 4.1, with normalised coordinates as in 4.4; r1, r2 and the
/// nearest rotation as in Zhang 2000, section 3.1 and appendix C). The translation then follows from the
/// rotation by linear least squares.
///
/// Nothing for fewer than four points, if they do not determine the pose (all on a line), or if a point would
/// lie behind its ray.
[[nodiscard]] std::optional<SE3> poseFromRays(std::span<const Eigen::Vector2d> on_board,
                                              std::span<const Eigen::Vector3d> rays);

/// The pose with the opposite tilt: the board's normal is mirrored at the line of sight to `middle` (a point
/// of the board), which stays in place. From a distance, both look alike.
[[nodiscard]] SE3 mirroredTilt(const SE3& camera_from_board, const Eigen::Vector3d& middle);

/// Pose of the board in a view, from the corners' rays through `camera` and with a flat board; corners at
/// pixels without a ray are left out. Nothing as above.
[[nodiscard]] std::optional<SE3> poseFromCorners(const AnyCamera& camera,
                                                 std::span<const Observation> corners);

/// The pose with the lowest robust cost near a good pose, with the camera fixed: Gauss-Newton steps, each
/// halved until it lowers the cost. It takes a few microseconds per view, whereas a general solver takes a
/// hundred. Nothing if a corner does not project from the initial pose.
[[nodiscard]] std::optional<SE3> refitPose(const ViewKernel& kernel, std::span<const double> params,
                                           std::span<const CornerGroup> corners, HuberLoss loss,
                                           const SE3& camera_from_board);
[[nodiscard]] std::optional<SE3> refitPose(std::string_view model_id, std::span<const double> params,
                                           std::span<const Observation> corners, HuberLoss loss,
                                           const SE3& camera_from_board);

}  // namespace alidade
