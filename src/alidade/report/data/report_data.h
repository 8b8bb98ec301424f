// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>

#include "alidade/camera/any_camera.h"
#include "alidade/core/diagnosis.h"
#include "alidade/core/image.h"
#include "alidade/geometry/se3.h"
#include "alidade/target/board.h"
#include "alidade/target/board_shape.h"

namespace alidade {

// What the report page draws, read from the evidence of a calibration (JSON, see docs/report.md). Numbers
// that the evidence leaves open (null) are NaN here.

/// A corner of a view.
struct ReportedCorner {
  int id = 0;
  Eigen::Vector2d pixel{0, 0};     ///< where it was seen
  Eigen::Vector2d error_px{0, 0};  ///< projected minus observed

  [[nodiscard]] Eigen::Vector2d projected() const { return pixel + error_px; }
};

/// A view of the fit, with what coverage says of it.
struct ReportedView {
  std::string image = {};
  std::size_t board = 0;  ///< index into ReportData::boards
  double rms_px = 0;
  double max_error_px = 0;
  SE3 camera_from_board = {};
  std::vector<ReportedCorner> corners = {};   ///< used by the fit
  std::vector<ReportedCorner> outliers = {};  ///< not used
  double distance_m = 0;
  double right_nearer_rad = 0;  ///< tilt, see BoardTilt
  double lower_nearer_rad = 0;
};

/// A board and the shape that the calibration found for it.
struct ReportedBoard {
  Board target;
  BoardShape shape = {};
};

/// The 95 % error over the image, see Accuracy.
struct ReportedAccuracy {
  bool is_by_covariance = false;  ///< of a camera file: nothing else is known, and the evidence lacks it
  double distance_m = std::numeric_limits<double>::infinity();
  int columns = 0;
  int rows = 0;
  std::vector<double> error_px = {};  ///< row by row; NaN where the pixel has no ray
  std::vector<bool> is_covered = {};
  double covered_px = 0;
  double covered_share = 0;
  double worst_px = 0;
  Eigen::Vector2d worst_pixel{0, 0};

  /// The pixel of a place of the grid, which goes from border to border.
  [[nodiscard]] Eigen::Vector2d pixel(int column, int row, const ImageSize& size) const;
  /// Share of the pixels with a ray whose error is at most this.
  [[nodiscard]] double shareWithin(double tolerance_px) const;
  [[nodiscard]] bool hasBlindPixels() const;
  /// Of what the shares are: "the image", or of its pixels with a ray where some have none.
  [[nodiscard]] const char* wholeName() const;
};

struct ReportedModel {
  std::string id = {};
  int num_params = 0;
  double rms_px = 0;
  double holdout_rms_px = 0;
  std::string verdict = {};
  std::string reason = {};
};

/// The photograph to take next.
struct ReportedNextView {
  std::size_t board = 0;
  SE3 camera_from_board = {};
  std::string text = {};  ///< in words
  double distance_m = 0;
  double right_nearer_rad = 0;
  double lower_nearer_rad = 0;
  double worst_now_px = 0;
  double worst_then_px = 0;
};

/// Corners per cell of a grid over the image, row by row; -1 where the lens has no ray.
struct ReportedCells {
  int columns = 0;
  int rows = 0;
  std::vector<int> num_corners = {};
};

/// Everything that the page draws of the calibration of one camera.
struct ReportData {
  AnyCamera camera;
  ImageSize size;
  Verdict verdict = Verdict::kNo;
  double tolerance_px = 1;
  std::vector<ReportedBoard> boards = {};
  std::vector<ReportedView> views = {};
  std::size_t first_view = 0;  ///< the number of the first one among all that the page can open
  std::vector<Diagnosis> findings = {};
  std::optional<ReportedAccuracy> accuracy = {};
  ReportedCells cells = {};
  double rms_px = 0;
  double holdout_rms_px = 0;
  double coordinate_sigma_px = 0;
  int num_corners = 0;
  int num_outliers = 0;
  int num_images_given = 0;
  int num_images_used = 0;
  std::vector<double> parameter_std = {};          ///< in storage order; NaN: unknown, 0: fixed
  std::optional<Eigen::MatrixXd> covariance = {};  ///< of the parameters in storage order
  std::vector<ReportedModel> models = {};
  std::optional<ReportedNextView> next_view = {};
  std::vector<std::string> reasons = {};  ///< a line for each image without a usable board
  std::vector<std::string> notes = {};
  std::string created_by = {};  ///< program and version
};

class JsonNode;

// Values that other documents have too.

/// The index of the board that has its SPEC stated in "board", or of the only one.
[[nodiscard]] std::size_t readBoardIndex(const JsonNode& node, const std::vector<ReportedBoard>& boards);
[[nodiscard]] ReportedCorner readCorner(const JsonNode& node, const Board& board);
/// Of N parameters, from the lower triangle row by row; nothing for null.
[[nodiscard]] std::optional<Eigen::MatrixXd> readCovariance(const JsonNode& node, int n);

/// Reads the evidence document of a calibration of one camera.
/// @param file  its name, for messages
/// @throws Error (kInput) naming the place of what is missing or of the wrong kind
[[nodiscard]] ReportData readReportData(const nlohmann::json& evidence, const std::string& file);

}  // namespace alidade
