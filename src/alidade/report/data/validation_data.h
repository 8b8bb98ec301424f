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
#include "alidade/report/data/report_data.h"
#include "alidade/report/figures/difference_figure.h"

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

/// One way in which the camera may be wrong, and what it would do.
struct ReportedChange {
  std::string id = {};    ///< "focal_length"
  std::string text = {};  ///< "focal length +3.1 % +- 0.2 %"
  double cost_drop = 0;   ///< share of the squared errors that it takes away
  double effect_px = 0;
  double sure_px = 0;
  double blind_px = 0;
};

/// Errors of a part of the image; NaN where nothing was seen.
struct ReportedFootageCell {
  int num_pixels = 0;
  double rms_px = 0;
  Eigen::Vector2d mean_px{0, 0};
};

/// What footage says of a camera with images of its size, or of an edited one.
struct ReportedFootageCheck {
  std::string edit = {};  ///< flags of `convert`; empty: the camera as it is
  std::string verdict = {};
  std::string explanation = {};  ///< id of a change; empty: none
  std::vector<ReportedChange> changes = {};
  int num_frames = 0;
  int num_points = 0;
  int num_pixels = 0;
  double holdout_rms_px = 0;  ///< NaN: nothing could be tested, as the noise
  double noise_px = 0;
  int columns = 0;
  int rows = 0;
  std::vector<ReportedFootageCell> cells = {};  ///< row by row; none: nothing could be tested
};

struct ReportedFootage {
  std::string verdict = {};  ///< "consistent", "inconsistent", "cannot_tell"
  ImageSize size;            ///< of its images
  double tolerance_px = 0;
  std::vector<ReportedFootageCheck> checks = {};  ///< one, or those of the edits that were tried
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
  std::optional<ReportedFootage> footage = {};
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
