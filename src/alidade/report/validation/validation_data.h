// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>

#include "alidade/camera/any_camera.h"
#include "alidade/core/diagnosis.h"
#include "alidade/core/image.h"
#include "alidade/report/difference_figure.h"
#include "alidade/report/report_data.h"

namespace alidade {

// What the page of a validation draws, read from the result of validate (JSON). Numbers that it leaves open
// (null) are NaN here.

/// The camera that images give by themselves.
struct ReportedFreed {
  AnyCamera camera;
  std::vector<double> parameter_std = {};  ///< in storage order; NaN: unknown, 0: fixed
  std::optional<Eigen::MatrixXd> covariance = {};
};

/// What images say of a camera.
struct ReportedHeldOut {
  int num_views_given = 0;
  int num_corners = 0;
  double rms_px = 0;        ///< of corners that had no part in their view's pose
  double noise_rms_px = 0;  ///< of them, if there were nothing but noise
  double fixed_rms_px = 0;  ///< with the poses fitted to all corners, and the camera as it is
  double freed_rms_px = 0;  ///< the same with the camera that the images give
  double p95_px = 0;        ///< between these two, where boards were seen
  double covered_share = 0;
  std::optional<ReportedFreed> freed = {};
  /// RMS of each view of ReportData::views with the camera as it is, and with the freed one, px.
  std::vector<double> view_fixed_px = {};
  std::vector<double> view_freed_px = {};
  std::vector<std::string> untested = {};  ///< images without a corner that could be tested
};

/// What a camera file states of its calibration.
struct ReportedStatement {
  Verdict verdict = Verdict::kNo;
  double accuracy_px = 0;
  double covered_share = 0;
};

/// A camera of a file.
struct ReportedCameraJudgement {
  std::string name = {};
  std::string model = {};  ///< empty: not supported
  std::vector<Diagnosis> checks = {};
  std::optional<ReportedStatement> stated = {};
  std::optional<ReportedHeldOut> held_out = {};
  /// For the figures: the errors of its views are those of corners that had no part in their view's pose.
  /// Nothing where the model is not supported or the image size not stated.
  std::optional<ReportData> data = {};
};

struct ReportedFile {
  std::string name = {};
  Severity status = Severity::kPass;
  std::string format = {};              ///< empty: it cannot be read
  std::optional<Diagnosis> error = {};  ///< why not
  std::vector<ReportedCameraJudgement> cameras = {};
  std::vector<Diagnosis> rig_checks = {};
};

struct ReportedValidation {
  bool is_strict = false;
  double tolerance_px = 0;
  std::vector<ReportedFile> files = {};
  std::vector<std::string> other_files = {};
  std::optional<RivalCamera> rival = {};  ///< with which the cameras were compared
  std::string created_by = {};

  [[nodiscard]] std::size_t count(Severity status) const;
};

/// @throws Error (kInput) for another document
[[nodiscard]] ReportedValidation readValidation(const nlohmann::json& document);

}  // namespace alidade
