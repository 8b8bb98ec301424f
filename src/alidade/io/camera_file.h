// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "alidade/camera/any_camera.h"
#include "alidade/camera/self_check.h"
#include "alidade/core/verdict.h"
#include "alidade/geometry/se3.h"
#include "alidade/target/board_shape.h"

namespace alidade {

struct ViewRecord {
  std::string image;
  int num_corners = 0;
  double rms_px = 0;
  SE3 camera_from_board;
};

/// The bend of the board that was estimated with the camera.
struct WarpRecord {
  BoardShape shape;
  Eigen::Vector2d std_m = Eigen::Vector2d::Zero();  ///< one sigma of bend_x and bend_y
};

/// A flag's name and its values, as the program used them.
using Setting = std::pair<std::string, std::vector<std::string>>;

/// How the parameters came about. Everything in it is for people and for later checks; projection needs none
/// of it.
struct CalibrationRecord {
  double rms_px = 0;
  int num_views = 0;
  int num_corners = 0;
  int num_outliers = 0;
  std::vector<double> parameter_std;  ///< one sigma, in parameter order; empty = unknown
  std::vector<double> covariance;     ///< lower triangle row by row, in parameter order; empty = unknown
  std::string termination;            ///< why the solver stopped
  Verdict verdict = Verdict::kTrustworthy;  ///< kNo where it was written all the same
  std::string board;                        ///< SPEC
  std::optional<WarpRecord> warp;           ///< none: the board was taken as flat
  std::vector<std::string> findings;        ///< ids of what the verdict rests on
  std::vector<ViewRecord> views;
  std::vector<Setting> settings;  ///< effective settings
};

/// The camera file, format version 1.
struct CameraFile {
  AnyCamera camera;
  ImageSize image_size;
  std::optional<DomainClaim> domain;
  std::vector<SelfCheckPoint> self_check;
  std::optional<CalibrationRecord> calibration;
  std::string created_by;
};

/// Reads a camera file strictly: unknown, missing, doubled and misspelt keys, wrong types, numbers that are
/// not finite and unknown models are errors that name line, key, found and expected. Only the first four keys
/// are needed.
/// @throws Error (kInput)
[[nodiscard]] CameraFile readCameraFile(const std::string& path);

/// The same from text; `name` stands for the file in messages.
[[nodiscard]] CameraFile parseCameraFile(const std::string& text, const std::string& name);

/// The file as text, with every number in the fewest digits that read back as the same double.
[[nodiscard]] std::string cameraFileText(const CameraFile& file);

/// Writes atomically. @throws Error (kInput)
void writeCameraFile(const std::string& path, const CameraFile& file);

}  // namespace alidade
