// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "alidade/camera/any_camera.h"
#include "alidade/core/random.h"
#include "alidade/record/hand_eye_record.h"
#include "alidade/record/robot_poses.h"
#include "alidade/target/board.h"
#include "alidade/target/view.h"

namespace alidade {

/// A robot with a camera on its hand, 5 to 12 cm from the flange, above a board on a table 0.6 m before the
/// base; or with the board in its hand, before a camera that stands 1 m from the base.
struct RobotScene {
  AnyCamera camera;
  ImageSize size;
  Board board;
  CameraOn camera_on = CameraOn::kHand;
  int num_views = 15;  ///< at most 1000
  RobotNoise robot_noise = {};
  double corner_noise_px = 0;  ///< standard deviation of each coordinate
};

/// What the robot and its camera give, and the truth. Without noise, camera_from_board of a view is
/// mount_from_camera^-1 * base_from_gripper^-1 (for kBase: base_from_gripper) * world_from_boards[0].
struct RobotSet {
  RobotScene scene;
  std::vector<View> views = {};  ///< named "000.png", ...
  RobotTable robot = {};         ///< a pose for each view
  SE3 mount_from_camera = {};    ///< see HandEyeRecord, like the next member
  std::vector<SE3> world_from_boards = {};
  std::vector<SE3> base_from_gripper = {};  ///< true: the stated one * exp([translation, rotation] noise)
};

/// Draws a set: the middle of the board anywhere in the image, 0.3 to 0.6 m away, tilted by up to 35 degrees
/// against the line of sight, turned about its normal by up to 60, with at least 60 % of its corners in the
/// image. A seed gives the same geometry with any noise.
/// @throws Error (kInput) if the camera cannot see so much of the board
[[nodiscard]] RobotSet simulateRobot(const RobotScene& scene, std::uint64_t seed);

/// True for the first four, which robotTableText() makes.
[[nodiscard]] constexpr bool isOfTable(RobotMistake mistake) {
  return mistake <= RobotMistake::kEulerOrder;
}

/// Makes the mistake in a set with poses. For a wrong reading, RobotTable::others gets the right one and two
/// more wrong ones, in any order. A moved board changes base_from_gripper, not the images.
void apply(RobotMistake mistake, RobotSet& set, Random& random);

}  // namespace alidade
