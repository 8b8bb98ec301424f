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
#include "alidade/geometry/dense_matrix.h"
#include "alidade/geometry/se3.h"
#include "alidade/target/board_shape.h"

namespace alidade {

struct UncertaintyGrid;

struct ViewRecord {
  std::string image;
  int num_corners = 0;
  double rms_px = 0;
  SE3 camera_from_board;
};

/// The bend of the board, estimated together with the camera.
struct WarpRecord {
  BoardShape shape;
  Eigen::Vector2d std_m = Eigen::Vector2d::Zero();  ///< standard deviation of bend_x and bend_y
};

/// Standard deviation in px of the pixel of a point at infinity, after alignment by the best rotation (see
/// ProjectionUncertainty).
struct ProjectionStdRecord {
  double center_px = 0;  ///< NaN if the image's centre has no ray
  double worst_px = 0;
  Eigen::Vector2d worst_pixel{0, 0};
  int columns = 0;  ///< of the grid, from border to border
  int rows = 0;
  std::vector<double> std_px;  ///< row by row; NaN if the pixel has no ray
};

/// A camera model that was considered in the automatic choice. Unknown values are NaN.
struct ModelRecord {
  std::string model;
  int num_parameters = 0;
  double rms_px = std::numeric_limits<double>::quiet_NaN();
  double holdout_rms_px = std::numeric_limits<double>::quiet_NaN();
  double excess = std::numeric_limits<double>::quiet_NaN();  ///< of its cross-validation RMS over the best
  double excess_std = std::numeric_limits<double>::quiet_NaN();
  std::string verdict;  ///< "chosen", or why not
};

/// A flag's name and its values, as the program used them.
using Setting = std::pair<std::string, std::vector<std::string>>;

/// How the parameters were estimated. This is for documentation and later checks; projection does not need
/// it.
struct CalibrationRecord {
  double rms_px = 0;
  double holdout_rms_px = std::numeric_limits<double>::quiet_NaN();  ///< NaN = unknown
  int num_views = 0;
  int num_corners = 0;
  int num_outliers = 0;
  std::vector<double> parameter_std;  ///< standard deviations, in parameter order; empty = unknown
  std::vector<double> covariance;     ///< lower triangle row by row, in parameter order; empty = unknown
  /// Standard deviations estimated from the differences between views; empty = unknown.
  std::vector<double> parameter_std_by_view;
  /// Lower triangle of the covariance to use if the one above is too small; empty = use the one above.
  std::vector<double> stated_covariance;
  std::optional<ProjectionStdRecord> projection_std;
  std::string termination;                  ///< why the solver stopped
  Verdict verdict = Verdict::kTrustworthy;  ///< kNo if the file was written anyway
  std::string board;                        ///< SPEC
  std::optional<WarpRecord> warp;           ///< empty: the board was assumed flat
  std::vector<ModelRecord> model_choice;    ///< empty: the user named the model
  std::vector<std::string> findings;        ///< ids of the findings behind the verdict
  std::vector<ViewRecord> views;
  std::vector<Setting> settings;  ///< effective settings
};

/// The content of a camera file: a camera and what is known about it. Only the camera and the image size are
/// required.
struct CameraRecord {
  AnyCamera camera;
  ImageSize image_size;
  std::optional<DomainClaim> domain = {};
  std::vector<SelfCheckPoint> self_check = {};
  std::optional<CalibrationRecord> calibration = {};
  std::string created_by = {};
  std::string user_keys = {};  ///< the user's keys (x_...) and values, as lines of YAML
};

/// A record of a camera without calibration data, with its domain and self-check points.
[[nodiscard]] CameraRecord bareRecord(const AnyCamera& camera, ImageSize size, std::string created_by);

/// A grid as the camera file has it, with four digits: more would be read by nobody. Nothing if no pixel has
/// a ray, or a sigma is not finite.
[[nodiscard]] std::optional<ProjectionStdRecord> projectionRecord(const UncertaintyGrid& grid);

/// The lower triangle of a symmetric matrix, row by row, as in CalibrationRecord.
[[nodiscard]] std::vector<double> lowerTriangle(const Eigen::MatrixXd& matrix);
[[nodiscard]] DenseMatrix fullMatrix(const std::vector<double>& lower_triangle, Eigen::Index n);

/// The covariance of the parameters to use, N x N in parameter order; std::nullopt if the record has none.
[[nodiscard]] std::optional<DenseMatrix> statedCovariance(const CameraRecord& record);

/// Whether this covariance assumes that views are independent, but not corners.
[[nodiscard]] bool isStatedByViews(const CameraRecord& record);

}  // namespace alidade
