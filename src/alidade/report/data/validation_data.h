// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "alidade/core/diagnosis.h"
#include "alidade/report/data/report_data.h"
#include "alidade/target/board.h"
#include "alidade/validate/camera_checks.h"

namespace alidade {

/// All that validate found out.
struct ValidationResult {
  std::vector<FileJudgement> files = {};
  std::vector<std::string> other_files = {};  ///< in folders; not camera files
  bool is_strict = false;                     ///< a warning fails a file
  double tolerance_px = 0;                    ///< for images and for the other camera
  std::vector<Board> boards = {};             ///< that the images show; none without images
  std::optional<RivalCamera> rival = {};      ///< with which the cameras were compared
  std::string created_by = {};                ///< program and version

  [[nodiscard]] bool isFailed(const FileJudgement& file) const {
    return file.severity() >= (is_strict ? Severity::kWarning : Severity::kFailure);
  }
  /// A failure, a warning or a pass.
  [[nodiscard]] Severity outcomeOf(const FileJudgement& file) const {
    if (isFailed(file)) return Severity::kFailure;
    return file.severity() == Severity::kWarning ? Severity::kWarning : Severity::kPass;
  }
};

/// A camera of a file as its page shows it. Texts are UTF-8.
struct JudgedCamera {
  const CameraJudgement* judgement = nullptr;
  std::string name = {};
  std::vector<Diagnosis> checks = {};
  /// For the figures: the errors of its views are those of corners that had no part in their view's pose.
  /// Nothing where the model is not supported or the image size not stated.
  std::optional<ReportData> data = {};
  std::vector<const HeldOutView*> tested = {};  ///< the views of `data`
  std::vector<std::string> untested = {};       ///< images without a corner that could be tested

  /// What images say of the camera; null without images.
  [[nodiscard]] const HeldOutJudgement* heldOut() const {
    return data && judgement->held_out ? &*judgement->held_out : nullptr;
  }
};

/// A file as its page shows it. Texts are UTF-8.
struct JudgedFile {
  const FileJudgement* judgement = nullptr;
  std::string name = {};
  Severity status = Severity::kPass;
  std::optional<Diagnosis> error = {};  ///< why it cannot be read
  std::vector<JudgedCamera> cameras = {};
  std::vector<Diagnosis> rig_checks = {};
};

/// Refers to `result`, which outlives the files.
[[nodiscard]] std::vector<JudgedFile> judgedFiles(const ValidationResult& result);

}  // namespace alidade
