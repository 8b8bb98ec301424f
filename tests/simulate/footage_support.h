// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "alidade/simulate/footage_simulator.h"

namespace alidade {

inline constexpr ImageSize kFootageSize = {.width = 320, .height = 240};

inline AnyCamera footagePinhole() {
  return AnyCamera::make("pinhole", std::vector<double>{250, 252, 158, 121});
}
inline AnyCamera footageRadtan() {
  return AnyCamera::make("radtan", std::vector<double>{250, 250, 159, 120, -0.25, 0.06, 1e-3, -5e-4, 0});
}
/// More than 185 degrees across the image's width.
inline AnyCamera footageFisheye() {
  return AnyCamera::make("kannala_brandt", std::vector<double>{97, 97, 159.5, 119.5, 0.01, -0.002, 0, 0});
}

inline FootageScene footageScene(const AnyCamera& camera) {
  return {.camera = camera, .image_size = kFootageSize, .num_frames = 20, .flow_px = 5, .num_jobs = 1};
}

/// Where a point would be seen if nothing hid it, in a frame without rolling shutter and stabilisation.
inline Projection unhidden(const FootageSimulator& simulator, const ScenePoint& point, int frame) {
  const SE3 camera_from_world = simulator.poseOf(frame);
  return simulator.cameraOf(frame).project(camera_from_world *
                                           simulator.positionOf(point, simulator.timeOf(frame)));
}

}  // namespace alidade
