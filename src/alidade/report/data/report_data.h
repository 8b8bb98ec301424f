// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>

#include "alidade/adjust/board/fit.h"
#include "alidade/calibrate/start/reports.h"
#include "alidade/calibrate/uncertainty/accuracy.h"
#include "alidade/camera/any_camera.h"
#include "alidade/core/diagnosis.h"
#include "alidade/core/image.h"
#include "alidade/geometry/dense_matrix.h"
#include "alidade/geometry/se3.h"
#include "alidade/guide/coverage.h"
#include "alidade/target/board.h"
#include "alidade/target/corner_error.h"

namespace alidade {

// What the report page draws, read from the evidence of a calibration (JSON, see docs/report.md). Numbers
// that the evidence leaves open (null) are NaN here.

/// A view of the fit, with what coverage says of it; or the photograph to take next, without errors.
struct ReportedView {
  std::string image = {};
  std::size_t board = 0;  ///< index into ReportData::boards
  double rms_px = 0;
  double max_error_px = 0;
  SE3 camera_from_board = {};
  std::vector<CornerError> corners = {};   ///< used by the fit
  std::vector<CornerError> outliers = {};  ///< not used
  double distance_m = 0;
  BoardTilt tilt = {};
};

/// A camera and views of boards, as figures draw them.
struct ReportData {
  AnyCamera camera;
  ImageSize size;
  double tolerance_px = 1;
  std::vector<FitBoard> boards = {};  ///< with their shapes
  std::vector<ReportedView> views = {};
  std::size_t first_view = 0;  ///< the number of the first one among all that the page can open
  std::vector<Diagnosis> findings = {};
  std::optional<Accuracy> accuracy = {};
  double rms_px = 0;
  double coordinate_sigma_px = 0;
  std::vector<double> parameter_std = {};          ///< in storage order; NaN: unknown, 0: fixed
  std::optional<Eigen::MatrixXd> covariance = {};  ///< of the parameters in storage order
};

/// Everything that the page draws of the calibration of one camera.
struct CalibrationEvidence : ReportData {
  Verdict verdict = Verdict::kNo;
  CoverageReport coverage = {};  ///< its grid alone
  double holdout_rms_px = 0;
  int num_outliers = 0;
  int num_images_given = 0;
  int num_images_used = 0;
  std::vector<ModelCandidate> models = {};
  std::optional<ReportedView> next_view = {};  ///< the photograph to take next
  std::string next_text = {};                  ///< the same in words
  std::vector<std::string> reasons = {};       ///< a line for each image without a usable board
  std::vector<std::string> notes = {};
  std::vector<std::string> settings = {};  ///< as flags: "--tolerance 1px"
};

/// The corners in all views.
[[nodiscard]] std::vector<CornerError> allCorners(const ReportData& data);
/// Whether some pixels of the image have no ray, and so no error.
[[nodiscard]] bool hasBlindPixels(const Accuracy& accuracy);
/// What its shares refer to: "the image", or "the pixels with a ray" where some have none.
[[nodiscard]] const char* wholeName(const Accuracy& accuracy);

/// Another camera, to compare the calibrated one with.
struct RivalCamera {
  std::string name;  ///< of its file
  AnyCamera camera;
  ImageSize size;
  std::optional<DenseMatrix> covariance = std::nullopt;  ///< of its parameters; empty: unknown
};

class JsonNode;

// Values that other documents have too.

/// The index of the board that has its SPEC stated in "board", or of the only one.
[[nodiscard]] std::size_t readBoardIndex(const JsonNode& node, const std::vector<FitBoard>& boards);
[[nodiscard]] CornerError readCorner(const JsonNode& node, const Board& board);
/// Of N parameters, from the lower triangle row by row; nothing for null.
[[nodiscard]] std::optional<Eigen::MatrixXd> readCovariance(const JsonNode& node, int n);

/// Reads the evidence document of a calibration of one camera.
/// @param file  its name, for messages
/// @throws Error (kInput) naming the place of what is missing or of the wrong kind
[[nodiscard]] CalibrationEvidence readCalibration(const nlohmann::json& evidence, const std::string& file);

}  // namespace alidade
