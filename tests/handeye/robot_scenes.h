// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "alidade/handeye/joint_fit.h"
#include "alidade/simulate/robot.h"
#include "support/image_sizes.h"

namespace alidade {

inline constexpr std::array kBothPlaces = {CameraOn::kHand, CameraOn::kBase};

/// A VGA camera and a board of 9 x 6 corners at 25 mm.
inline RobotScene robotScene(CameraOn camera_on, const RobotNoise& robot_noise = {},
                             double corner_noise_px = 0, int num_views = 15) {
  return {.camera =
              AnyCamera::make("radtan", std::vector<double>{510, 512, 324, 236, -0.25, 0.08, 5e-4, -3e-4, 0}),
          .size = kVga,
          .board = Checkerboard{.columns = 9, .rows = 6, .square_m = 0.025},
          .camera_on = camera_on,
          .num_views = num_views,
          .robot_noise = robot_noise,
          .corner_noise_px = corner_noise_px};
}

/// True camera_from_board.
inline SE3 cameraFromBoard(const RobotSet& set, std::size_t view, const SE3& world_from_board) {
  return set.mount_from_camera.inverse() * motionOf(set.scene.camera_on, set.base_from_gripper[view]) *
         world_from_board;
}

/// [translation (m), rotation (rad)] by which one is off the other.
inline SE3::Tangent differenceOf(const SE3& truth, const SE3& found) {
  return (truth.inverse() * found).log();
}

}  // namespace alidade
