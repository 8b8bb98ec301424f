// SPDX-License-Identifier: MIT
#include "support/poor_set.h"

#include <string>

namespace alidade {
namespace {

// Which side of the image a set keeps to.
struct Side {
  int axis = 0;
  bool is_upper = false;

  [[nodiscard]] bool has(const Eigen::Vector2d& pixel, ImageSize size) const {
    const double middle = 0.5 * (axis == 0 ? size.width : size.height);
    return (pixel(axis) < middle) == is_upper;
  }
};

}  // namespace

SimulatedSet drawPoorSet(std::string_view model_id, std::uint64_t seed) {
  Random random(seed);
  const bool is_wide = model_id == "kannala_brandt";
  const DrawnCamera drawn =
      drawCamera(model_id, is_wide ? random.uniform(90, 140) : random.uniform(55, 95), random);
  SimulatedSet set{.camera = drawn.camera,
                   .size = drawn.size,
                   .board = {.columns = 9, .rows = 6, .square_m = 0.025},
                   .poses = {},
                   .views = {}};
  const auto num_views = 4 + random.index(9);
  RandomViewOptions options;
  options.max_tilt_deg = random.uniform(10, 45);
  options.min_fill = random.uniform(0.2, 0.4);
  options.max_fill = options.min_fill + random.uniform(0.05, 0.4);
  const bool is_one_sided = random.index(2) == 0;
  const Side side = {.axis = static_cast<int>(random.index(2)), .is_upper = random.index(2) == 0};
  const Eigen::Vector3d middle = set.board.middle();
  while (set.poses.size() < num_views) {
    const SE3 pose = randomViews(set.camera, set.size, set.board, 1, random, options).front();
    if (is_one_sided && !side.has(set.camera.project(pose * middle).pixel, set.size)) continue;
    View view = exactView(set.camera, set.size, set.board, pose, "view_" + std::to_string(set.poses.size()));
    addCornerNoise(view, kPoorSetNoisePx, random);
    set.poses.push_back(pose);
    set.views.push_back(std::move(view));
  }
  return set;
}

std::vector<SE3> drawOtherViews(const SimulatedSet& set, int count, std::uint64_t seed) {
  Random random(seed);
  RandomViewOptions options;
  options.min_fill = 0.25;
  options.max_fill = 0.95;
  return randomViews(set.camera, set.size, set.board, count, random, options);
}

View noisyView(const SimulatedSet& set, const SE3& camera_from_board, const std::string& name,
               std::uint64_t seed) {
  View view = exactView(set.camera, set.size, set.board, camera_from_board, name);
  Random random(seed);
  addCornerNoise(view, kPoorSetNoisePx, random);
  return view;
}

}  // namespace alidade
