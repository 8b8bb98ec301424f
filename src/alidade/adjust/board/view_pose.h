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
/// sees them, in any direction, behind the camera too. With q = (x, y, 1), a point lies on its ray b if
/// b x (H q) = 0, where H = [r1 r2 t] up to scale: linear in H, solved as the direct linear transform of rays
/// (Hartley and Zisserman, 2nd ed., section 4.1, with normalised coordinates as in 4.4; r1, r2 and the
/// nearest rotation as in Zhang 2000, section 3.1 and appendix C). The translation then follows from the
/// rotation by linear least squares.
///
/// Nothing for fewer than four points, where they do not determine the pose (all on a line), or where some
/// point would lie behind its ray.
[[nodiscard]] std::optional<SE3> poseFromRays(std::span<const Eigen::Vector2d> on_board,
                                              std::span<const Eigen::Vector3d> rays);

/// The pose with the tilt on the other side: the board's normal mirrored at the line of sight to `middle` (a
/// point of the board), which stays where it is. From afar the two look alike.
[[nodiscard]] SE3 mirroredTilt(const SE3& camera_from_board, const Eigen::Vector3d& middle);

/// Pose of the board in a view: that of the corners' rays through `camera`, the board taken as flat; corners
/// at pixels that have no ray are left out. Nothing as above.
[[nodiscard]] std::optional<SE3> poseFromCorners(const AnyCamera& camera,
                                                 std::span<const Observation> corners);

/// The pose with the least robust cost near a good one, the camera as it is: Gauss and Newton's steps, each
/// halved until it lowers the cost. Some microseconds a view, where a solver that is set up for one pose
/// takes a hundred. Nothing where a corner does not project from the pose to begin with.
[[nodiscard]] std::optional<SE3> refitPose(const ViewKernel& kernel, std::span<const double> params,
                                           std::span<const CornerGroup> corners, HuberLoss loss,
                                           const SE3& camera_from_board);
[[nodiscard]] std::optional<SE3> refitPose(std::string_view model_id, std::span<const double> params,
                                           std::span<const Observation> corners, HuberLoss loss,
                                           const SE3& camera_from_board);

}  // namespace alidade
