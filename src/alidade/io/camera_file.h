// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
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

/// One standard deviation of the pixel of a point infinitely far away, the best rotation taken out, in px
/// (see ProjectionUncertainty).
struct ProjectionStdRecord {
  double center_px = 0;  ///< NaN if the image's centre has no ray
  double worst_px = 0;
  Eigen::Vector2d worst_pixel{0, 0};
  int columns = 0;  ///< of the grid, from border to border
  int rows = 0;
  std::vector<double> std_px;  ///< row by row; NaN where the pixel has no ray
};

/// A camera model that was considered when one was chosen. What is not known is NaN.
struct ModelRecord {
  std::string model;
  int num_parameters = 0;
  double rms_px = std::numeric_limits<double>::quiet_NaN();
  double holdout_rms_px = std::numeric_limits<double>::quiet_NaN();
  double excess = std::numeric_limits<double>::quiet_NaN();  ///< of the held-out RMS over the best model's
  double excess_std = std::numeric_limits<double>::quiet_NaN();
  std::string verdict;  ///< "chosen", or why not
};

/// A flag's name and its values, as the program used them.
using Setting = std::pair<std::string, std::vector<std::string>>;

/// How the parameters came about. Everything in it is for people and for later checks; projection needs none
/// of it.
struct CalibrationRecord {
  double rms_px = 0;
  double holdout_rms_px = std::numeric_limits<double>::quiet_NaN();  ///< NaN = unknown
  int num_views = 0;
  int num_corners = 0;
  int num_outliers = 0;
  std::vector<double> parameter_std;  ///< one sigma, in parameter order; empty = unknown
  std::vector<double> covariance;     ///< lower triangle row by row, in parameter order; empty = unknown
  /// One sigma by how the views agree, to use like a normal one; empty = unknown.
  std::vector<double> parameter_std_by_view;
  /// Lower triangle of the covariance to go by, where the one above is too small; empty = that one.
  std::vector<double> stated_covariance;
  std::optional<ProjectionStdRecord> projection_std;
  std::string termination;                  ///< why the solver stopped
  Verdict verdict = Verdict::kTrustworthy;  ///< kNo where it was written all the same
  std::string board;                        ///< SPEC
  std::optional<WarpRecord> warp;           ///< none: the board was taken as flat
  std::vector<ModelRecord> model_choice;    ///< empty: the model was named
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
/// are needed. The file has to pass its own self-check, see requireSelfCheck().
/// @throws Error (kInput)
[[nodiscard]] CameraFile readCameraFile(const std::string& path);

/// The same from text; `name` stands for the file in messages.
[[nodiscard]] CameraFile parseCameraFile(const std::string& text, const std::string& name);

/// Passes if the camera projects the file's self-check points to their pixels (none: nothing to compare), so
/// that a number that was changed by hand is not used without a word.
/// @throws Error (kInput) with the worst point and by how much it is off
void requireSelfCheck(const CameraFile& file, const std::string& where);

/// The file of a camera of which nothing else is known: with its domain and points to check itself by.
[[nodiscard]] CameraFile bareCameraFile(const AnyCamera& camera, ImageSize size, std::string created_by);

/// The file as text, with every number in the fewest digits that read back as the same double.
[[nodiscard]] std::string cameraFileText(const CameraFile& file);

/// Writes atomically. @throws Error (kInput)
void writeCameraFile(const std::string& path, const CameraFile& file);

}  // namespace alidade
