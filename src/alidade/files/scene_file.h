// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "alidade/geometry/se3.h"
#include "alidade/record/footage_scene.h"
#include "alidade/record/scene.h"

namespace alidade {

/// Content of a scene file: views of a board, or ordinary footage.
using AnyScene = std::variant<Scene, FootageScene>;

/// Reads a scene. Views of a board:
///
///   alidade_scene: 1
///   camera: camera.yaml            # a camera file, or a map of its model, image_size, parameters
///   board: checkerboard:9x6:25mm   # or a board file
///   views: {random: 12}            # or {poses: [...]}, each as in pose_list.h
///   seed: 1
///   random: {max_tilt_deg: 45, max_roll_deg: 30, min_fill: 0.35, max_fill: 0.8, margin_px: 4}
///   render: {blur_px: 0.8, read_noise: 1.5, full_well_electrons: 10000, dark_level: 30, bright_level: 220,
///            background_level: 110, border_square: 1, falloff: 0, vignetting_exponent: 0, samples: 377}
///   corner_noise_px: 0
///
/// camera, board and views are needed. In place of views, a robot moves the camera, or the board before it:
///
///   robot: {camera_on: hand, poses: 15, rotation_noise_rad: 0.0005, translation_noise_m: 0.0002, mistake:
///   swapped}
///
/// where mistake is one of the RobotMistake, and may be left out. Footage, see FootageScene, has other keys
/// in place of board and views:
///
///   alidade_scene: 1
///   camera: camera.yaml
///   footage: {surroundings: room, path: walk, frames: 60, frame_rate_hz: 30, flow_px: 0, shake_px: 0,
///             moving_objects: 0, moving_share: 0, rolling_shutter: 0, stabilisation_frames: 0, zoom: 1}
///   seed: 1
///   render: {blur_px: 0.7, read_noise: 1.5}
///
/// camera and footage are needed. surroundings: room, plane or far; path: walk, rotation, static or straight.
/// File names are relative to the scene's folder.
/// @throws Error (kInput) naming line and key
[[nodiscard]] AnyScene readSceneFile(const std::string& path);

/// The same from text; `name` is the file name in messages and the base for relative paths.
[[nodiscard]] AnyScene parseSceneFile(const std::string& text, const std::string& name);

/// Text of a YAML list of the true poses: image and pose of each picture. `key` names the frames of the
/// poses: camera_from_board or camera_from_world.
[[nodiscard]] std::string posesText(const std::vector<std::string>& images, const std::string& key,
                                    const std::vector<SE3>& camera_from_x);

}  // namespace alidade
