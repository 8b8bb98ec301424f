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
#include "alidade/record/camera_record.h"
#include "alidade/target/board.h"
#include "alidade/target/corner_error.h"

namespace alidade {

// Data of the report page, read from the evidence of a calibration (JSON, see docs/report.md). Numbers that
// are null in the evidence are NaN here.

/// Where a result comes from, as documents and the headers of pages state it.
struct RunOrigin {
  std::string created_by = {};           ///< program and version
  std::vector<std::string> inputs = {};  ///< as given; those of a flag begin with it
  CameraName camera = {};                ///< as the user states it; only name and serial number
  std::string date = {};                 ///< as the user states it; empty: not stated
};

/// The document with the keys "created_by" and "origin".
[[nodiscard]] nlohmann::json withOrigin(nlohmann::json document, const RunOrigin& origin);

/// A view of the fit, with its coverage; or the photograph to take next, without errors.
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
  std::size_t camera = 0;     ///< of a rig: index into ReportedRig::cameras
  std::size_t placement = 0;  ///< of a rig: index into ReportedRig::placements
};

/// A camera and views of boards, as input of figures.
struct ReportData {
  AnyCamera camera;
  ImageSize size;
  double tolerance_px = 1;
  std::vector<FitBoard> boards = {};  ///< with their shapes
  std::vector<ReportedView> views = {};
  std::size_t first_view = 0;  ///< number of the first one among all views that the page can open
  std::vector<Diagnosis> findings = {};
  std::optional<Accuracy> accuracy = {};
  double rms_px = 0;
  double coordinate_sigma_px = 0;
  std::vector<double> parameter_std = {};          ///< in storage order; NaN: unknown, 0: fixed
  std::vector<double> pupil_std_m = {};            ///< of the entrance pupil, if it was estimated
  std::optional<Eigen::MatrixXd> covariance = {};  ///< of the parameters in storage order
};

/// All data of the page of a single-camera calibration.
struct CalibrationEvidence : ReportData {
  Verdict verdict = Verdict::kNo;
  CoverageReport coverage = {};  ///< only its grid
  double holdout_rms_px = 0;
  int num_outliers = 0;
  int num_images_given = 0;
  int num_images_used = 0;
  std::vector<ModelCandidate> models = {};
  std::optional<ReportedView> next_view = {};  ///< the photograph to take next
  std::string next_text = {};                  ///< the same in words
  std::vector<std::string> reasons = {};       ///< one line for each image without a usable board
  std::vector<std::string> notes = {};
  std::vector<std::string> settings = {};  ///< as flags: "--tolerance 1px"
  RunOrigin origin = {};
};

/// The corners in all views.
[[nodiscard]] std::vector<CornerError> allCorners(const ReportData& data);
/// True if some pixels of the image have no ray, and so no error.
[[nodiscard]] bool hasBlindPixels(const Accuracy& accuracy);
/// The whole that shares refer to: "the image", or "the pixels with a ray" if some have none.
[[nodiscard]] const char* wholeName(const Accuracy& accuracy);

/// A second camera to compare the calibrated one with.
struct RivalCamera {
  std::string name;  ///< of its file
  AnyCamera camera;
  ImageSize size;
  std::optional<DenseMatrix> covariance = std::nullopt;  ///< of its parameters; empty: unknown
};

class JsonNode;

// Readers of values that also occur in other documents.

/// The index of the board with the SPEC under "board", or of the only board.
[[nodiscard]] std::size_t readBoardIndex(const JsonNode& node, const std::vector<FitBoard>& boards);
[[nodiscard]] CornerError readCorner(const JsonNode& node, const Board& board);
/// The origin of a document; of an older one, only its program.
[[nodiscard]] RunOrigin readOrigin(const JsonNode& root);
/// Nothing for null.
[[nodiscard]] std::optional<Accuracy> readAccuracy(const JsonNode& node);
/// A matrix for N parameters, from the lower triangle row by row; nothing for null.
[[nodiscard]] std::optional<Eigen::MatrixXd> readCovariance(const JsonNode& node, int n);

/// Reads the evidence document of a calibration of one camera.
/// @param file  its name, for messages
/// @throws Error (kInput) naming the place of a missing value or one of the wrong kind
[[nodiscard]] CalibrationEvidence readCalibration(const nlohmann::json& evidence, const std::string& file);

}  // namespace alidade
