// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "alidade/camera/any_camera.h"
#include "alidade/geometry/se3.h"
#include "alidade/report/canvas/figure_canvas.h"
#include "alidade/report/data/report_data.h"
#include "alidade/target/board.h"

namespace alidade {

struct SceneBoard {
  const Board* target = nullptr;
  SE3 scene_from_board = {};
  std::optional<std::size_t> view = std::nullopt;  ///< view that a click opens
  std::string words = {};                          ///< text for a shape that opens no view
  bool is_next = false;                            ///< suggested, not seen
};

struct SceneCamera {
  const AnyCamera* camera = nullptr;
  ImageSize size;
  SE3 scene_from_camera = {};
  std::string name = {};
};

struct SceneContent {
  std::string title;
  std::string reading;
  std::vector<SceneBoard> boards = {};
  std::vector<SceneCamera> cameras = {};
  double camera_share =
      0.16;  ///< length of a camera's edges, as a share of the distance of the farthest board
};

/// Boards and cameras in space. Each shape carries its points in data-points (metres, x y z for each), from
/// which the page's script redraws the scene when it is turned; the initial drawing uses data-yaw and
/// data-pitch (degrees).
[[nodiscard]] Figure sceneFigure(const SceneContent& content);
/// The same for a calibration of one camera, in the camera frame.
[[nodiscard]] Figure sceneFigure(const CalibrationEvidence& data);

}  // namespace alidade
