// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "alidade/target/view.h"

namespace alidade {

/// The views of one camera of a rig.
struct RigViews {
  std::string name;  ///< of the camera
  std::vector<View> views;
};

/// The instants at which a rig took images.
struct RigFrames {
  std::vector<std::string> names;                  ///< in natural order
  std::vector<std::vector<std::size_t>> frame_of;  ///< of each view of each camera, an index into `names`
};

/// Finds which images were taken at the same time: those of the same name without folder and extension, or,
/// if no two cameras have such, those whose names have the same last number ("left01.jpg", "right1.png").
/// @throws Error (kInput) if an image's name has no number, or two images of a camera have the same one
[[nodiscard]] RigFrames matchFrames(std::span<const RigViews> cameras);

}  // namespace alidade
