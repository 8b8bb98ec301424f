// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "alidade/camera/any_camera.h"
#include "alidade/simulate/observe.h"
#include "alidade/simulate/random_views.h"

namespace alidade {

/// Views of a board by a known camera: corners only, no images.
struct SimulatedSet {
  AnyCamera camera;
  ImageSize size;
  Checkerboard board;
  std::vector<SE3> poses;
  std::vector<View> views;
};

inline SimulatedSet simulateSet(const AnyCamera& camera, ImageSize size, int num_views, double noise_px,
                                std::uint64_t seed, const RandomViewOptions& options = {},
                                const Checkerboard& board = {.columns = 9, .rows = 6, .square_m = 0.025}) {
  Random random(seed);
  SimulatedSet set{.camera = camera, .size = size, .board = board, .poses = {}, .views = {}};
  set.poses = randomViews(camera, size, board, num_views, random, options);
  for (int i = 0; i < num_views; ++i) {
    View view =
        exactView(camera, size, board, set.poses[static_cast<std::size_t>(i)], "view_" + std::to_string(i));
    if (noise_px > 0) addCornerNoise(view, noise_px, random);
    set.views.push_back(std::move(view));
  }
  return set;
}

/// Leaves out corners outside the image, which no detector sees.
inline void dropOutside(std::vector<View>& views) {
  for (View& view : views) {
    std::erase_if(view.corners, [&](const Corner& corner) {
      return corner.pixel.minCoeff() < -0.5 || corner.pixel.x() > view.size.width - 0.5 ||
             corner.pixel.y() > view.size.height - 0.5;
    });
  }
}

/// Focal length at which a lens without distortion sees `fov_deg` across the width.
inline double focalForFov(double fov_deg, ImageSize size) {
  return 0.5 * size.width / std::tan(0.5 * fov_deg * std::numbers::pi / 180);
}

}  // namespace alidade
