// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "alidade/camera/any_camera.h"
#include "alidade/geometry/se3.h"
#include "alidade/simulate/random_views.h"
#include "alidade/simulate/render.h"
#include "alidade/target/checkerboard.h"

namespace alidade {

/// What to simulate: a camera, a board, and the poses of the board, given or drawn at random.
struct Scene {
  AnyCamera camera;
  ImageSize image_size;
  Checkerboard board;
  std::vector<SE3> camera_from_board;  ///< given poses; empty = draw `num_random_views`
  int num_random_views = 0;
  std::uint64_t seed = 1;  ///< of poses and corner noise
  RandomViewOptions random_views;
  RenderOptions render;
  double corner_noise_px = 0;  ///< added to the corners file; 0 = exact
  /// What was passed over or assumed in reading the camera's file, a sentence each.
  std::vector<std::string> camera_remarks = {};
};

/// Reads a scene:
///
///   alidade_scene: 1
///   camera: camera.yaml            # a camera file, or a map of its model, image_size, parameters
///   board: checkerboard:9x6:25mm   # or a board file
///   views: {random: 12}            # or {poses: [...]}, each as in pose_file.h
///   seed: 1
///   random: {max_tilt_deg: 45, max_roll_deg: 30, min_fill: 0.35, max_fill: 0.8, margin_px: 4}
///   render: {blur_px: 0.8, read_noise: 1.5, full_well_electrons: 10000, dark_level: 30, bright_level: 220,
///            background_level: 110, falloff: 0, vignetting_exponent: 0, samples: 377}
///   corner_noise_px: 0
///
/// camera, board and views are needed. Files are looked for from the scene's folder.
/// @throws Error (kInput) naming line and key
[[nodiscard]] Scene readSceneFile(const std::string& path);

/// The same from text; `name` stands for the file in messages and in the search for other files.
[[nodiscard]] Scene parseSceneFile(const std::string& text, const std::string& name);

/// Text of a YAML list of the true poses: image and camera_from_board of each view.
[[nodiscard]] std::string posesText(const std::vector<std::string>& images,
                                    const std::vector<SE3>& camera_from_board);

}  // namespace alidade
