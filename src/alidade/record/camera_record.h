// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"
#include "alidade/camera/self_check.h"
#include "alidade/core/diagnosis.h"
#include "alidade/geometry/dense_matrix.h"
#include "alidade/target/board_shape.h"

namespace alidade {

/// The bend of a board, estimated together with the camera.
struct WarpRecord {
  std::size_t board = 0;  ///< index into CalibrationRecord::boards
  BoardShape shape = {};
  Eigen::Vector2d std_m = Eigen::Vector2d::Zero();  ///< standard deviation of bend_x and bend_y
};

/// How the parameters were estimated. For documentation and later checks; not needed for projection.
struct CalibrationRecord {
  Verdict verdict = Verdict::kTrustworthy;  ///< kNo if the file was written despite failures
  std::string date = {};                    ///< as the user states it; empty: not stated
  /// The largest error of a pixel where boards were seen that is not exceeded with a probability of 95 %; NaN
  /// = unknown.
  double accuracy_px = std::numeric_limits<double>::quiet_NaN();
  double accuracy_distance_m = std::numeric_limits<double>::infinity();  ///< of the point
  double covered_share = std::numeric_limits<double>::quiet_NaN();  ///< of the image, where boards were seen
  double rms_px = 0;
  double holdout_rms_px = std::numeric_limits<double>::quiet_NaN();  ///< NaN = unknown
  int num_views = 0;
  int num_corners = 0;
  std::vector<std::string> boards;     ///< SPECs of the boards that the views show
  std::vector<WarpRecord> warps = {};  ///< in the order of the boards; boards without one were assumed flat
  std::vector<std::string> findings = {};  ///< ids of the findings behind the verdict
  std::vector<double> parameter_std = {};  ///< standard deviations, in parameter order; empty = unknown
  /// Standard deviations of the numbers of the entrance pupil that were estimated, metres.
  std::vector<double> pupil_std = {};
  std::vector<double> covariance = {};  ///< lower triangle row by row, in parameter order; empty = unknown
  /// The covariance assumes that views are independent, but not their corners.
  bool is_covariance_by_views = false;
  /// The means of the corners of the first kMaxViewCenters views, px, to recognise their images by.
  std::vector<Eigen::Vector2d> view_centers = {};
  static constexpr std::size_t kMaxViewCenters = 40;
};

/// Names that the user gives a camera. All may be empty.
struct CameraName {
  std::string name;
  std::string serial;
  std::string lens;

  [[nodiscard]] bool isEmpty() const { return name.empty() && serial.empty() && lens.empty(); }
};

/// The content of a camera file: a camera and what is known about it. Only the camera and the image size are
/// required.
struct CameraRecord {
  AnyCamera camera;
  ImageSize image_size;
  CameraName name = {};
  std::optional<DomainClaim> domain = {};
  std::vector<SelfCheckPoint> self_check = {};
  std::optional<CalibrationRecord> calibration = {};
  std::string created_by = {};
  std::string user_keys = {};  ///< the user's keys (x_...) and values, as lines of YAML
};

/// A record of a camera without calibration data, with its domain and self-check points.
[[nodiscard]] CameraRecord bareRecord(const AnyCamera& camera, ImageSize size, std::string created_by);

/// The lower triangle of a symmetric matrix, row by row, as in CalibrationRecord.
[[nodiscard]] std::vector<double> lowerTriangle(const Eigen::MatrixXd& matrix);
[[nodiscard]] DenseMatrix fullMatrix(const std::vector<double>& lower_triangle, Eigen::Index n);

/// The covariance of the parameters to use, N x N in parameter order; std::nullopt if the record has none.
[[nodiscard]] std::optional<DenseMatrix> statedCovariance(const CameraRecord& record);

}  // namespace alidade
