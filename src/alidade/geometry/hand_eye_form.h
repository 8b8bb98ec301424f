// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "alidade/geometry/se3.h"

namespace alidade {

/// A board as a camera sees it on a mount that moves, such as a robot.
struct SeenFrom {
  SE3 motion;             ///< mount_from_world at this place
  SE3 camera_from_board;  ///< by the image alone
  std::size_t board = 0;
  /// Frames of different parts tell nothing about each other: the board was moved between.
  std::size_t part = 0;
};

/// mount_from_camera and world_from_boards without a start.
struct ClosedForm {
  SE3 mount_from_camera;
  std::vector<SE3> world_from_boards;  ///< one per board
  /// Median over the frames of what is left, as seen by the camera: rad, and share of the distance.
  double median_rad = 0;
  double median_share = 0;
  /// How well turns about more than one axis determine the mount's rotation: the middle eigenvalue of the
  /// scatter of the turns between pairs, rad^2. 0: not at all.
  double rotation_firmness = 0;
  Eigen::Vector3d main_axis = Eigen::Vector3d::Zero();  ///< of the turns, in the camera frame
  double main_turn = 0;                                 ///< mean square of the turns about it, rad^2

  [[nodiscard]] double misfit() const { return std::hypot(median_rad, median_share); }
};

/// Solves A X = X B for the motions between pairs of frames, rotation before translation, in terms of their
/// rotation vectors (Park and Martin 1994, Robot sensor calibration: solving AX = XB on the Euclidean group,
/// IEEE Transactions on Robotics and Automation 10(5)), with pairs that contradict most others weighted down.
/// @pre at least two frames of each part in use
[[nodiscard]] ClosedForm closedForm(std::span<const SeenFrom> frames, std::size_t num_boards);

/// What the closed form leaves of a frame: the tangent of camera_from_board from its prediction to the image.
[[nodiscard]] SE3::Tangent leftOver(const ClosedForm& form, const SeenFrom& frame);

}  // namespace alidade
