// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

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

/// A camera and all that is known of it, as the camera file holds it. Only the camera and the size of its
/// images are needed.
struct CameraRecord {
  AnyCamera camera;
  ImageSize image_size;
  std::optional<DomainClaim> domain;
  std::vector<SelfCheckPoint> self_check;
  std::optional<CalibrationRecord> calibration;
  std::string created_by;
  std::string user_keys = {};  ///< the user's own, x_..., and their values: lines of YAML
};

/// The record of a camera of which nothing else is known: with its domain and points to check itself by.
[[nodiscard]] CameraRecord bareRecord(const AnyCamera& camera, ImageSize size, std::string created_by);

/// A symmetric matrix as CalibrationRecord holds it: the lower triangle, row by row.
[[nodiscard]] std::vector<double> lowerTriangle(const Eigen::MatrixXd& matrix);
[[nodiscard]] Eigen::MatrixXd fullMatrix(const std::vector<double>& lower_triangle, Eigen::Index n);

/// The covariance of the parameters to use, N x N in parameter order; nothing where the record states none.
[[nodiscard]] std::optional<Eigen::MatrixXd> statedCovariance(const CameraRecord& record);

/// Whether that covariance assumes independent views only, and not independent corners.
[[nodiscard]] bool isStatedByViews(const CameraRecord& record);

}  // namespace alidade
