// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"
#include "alidade/geometry/se3.h"
#include "alidade/target/checkerboard.h"

namespace alidade {

/// How far a board is turned out of the pose in which the lens shows it square, radians. In that pose no side
/// appears larger than the opposite one: parallel to the image for a pinhole, facing the line of sight for an
/// equidistant fisheye. Sides are those of the image, whichever way the board is printed.
struct BoardTilt {
  double right_rad = 0;  ///< positive: the right side is nearer to the camera than the left one
  double lower_rad = 0;  ///< positive: the lower side is nearer than the upper one

  /// Between the board and its square pose.
  [[nodiscard]] double total() const;
};

/// Where a board is and how it is held, as the camera's user sees it.
struct BoardSighting {
  Eigen::Vector2d middle_px{0, 0};  ///< of the board's corners; NaN where the camera does not see it
  double distance_m = 0;            ///< of that middle from the camera
  BoardTilt tilt;
};

/// camera_from_square: z is the normal, away from the camera, of the plane that `camera` shows square around
/// a pixel, x runs to the right in the image. Nothing where the pixel has no ray.
[[nodiscard]] std::optional<SO3> squarePose(const AnyCamera& camera, const Eigen::Vector2d& pixel);

[[nodiscard]] BoardSighting sightBoard(const AnyCamera& camera, const Checkerboard& board,
                                       const SE3& camera_from_board);

/// The rotation square_from_board of an upright board with this tilt. Less than 90 degrees each.
[[nodiscard]] SO3 tiltedBoard(const BoardTilt& tilt);

/// "its left side nearer to you by 40 degrees and its upper side by 20 degrees"; for less than 5 degrees both
/// ways "not tilted".
[[nodiscard]] std::string tiltText(const BoardTilt& tilt);

}  // namespace alidade
