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

/// All results of validate.
struct ValidationResult {
  std::vector<FileJudgement> files = {};
  std::vector<std::string> other_files = {};  ///< in folders; not camera files
  bool is_strict = false;                     ///< a warning counts as a failure of the file
  double tolerance_px = kDefaultTolerancePx;  ///< for images, for the comparison and for maps
  std::vector<Board> boards = {};             ///< that the images show; none without images
  std::optional<RivalCamera> rival = {};      ///< reference for the comparison
  RunOrigin origin = {};

  [[nodiscard]] bool isFailed(const FileJudgement& file) const {
    return file.severity() >= (is_strict ? Severity::kWarning : Severity::kFailure);
  }
  /// A failure, a warning or a pass.
  [[nodiscard]] Severity outcomeOf(const FileJudgement& file) const {
    if (isFailed(file)) return Severity::kFailure;
    return file.severity() == Severity::kWarning ? Severity::kWarning : Severity::kPass;
  }
};

/// A camera of a file, for display on a page. Texts are UTF-8.
struct JudgedCamera {
  const CameraJudgement* judgement = nullptr;
  std::string name = {};
  std::vector<Diagnosis> checks = {};
  /// For the figures: the errors are those of corners not used for their view's pose. Nothing if the model is
  /// not supported or the image size not stated.
  std::optional<ReportData> data = {};
  std::vector<const HeldOutView*> tested = {};  ///< the views of `data`
  std::vector<std::string> untested = {};       ///< images without a testable corner

  /// Findings from images; null without images.
  [[nodiscard]] const HeldOutJudgement* heldOut() const {
    return data && judgement->held_out ? &*judgement->held_out : nullptr;
  }
};

/// A file, for display on a page. Texts are UTF-8.
struct JudgedFile {
  const FileJudgement* judgement = nullptr;
  std::string name = {};
  Severity status = Severity::kPass;
  std::optional<Diagnosis> error = {};  ///< reason why it cannot be read
  std::vector<JudgedCamera> cameras = {};
  std::vector<Diagnosis> rig_checks = {};

  /// True if the file has no failure, but failed because warnings count as failures.
  [[nodiscard]] bool isFailedByWarnings() const {
    return status == Severity::kFailure && judgement->severity() < Severity::kFailure;
  }
};

/// The results refer to `result`, which must outlive them.
[[nodiscard]] std::vector<JudgedFile> judgedFiles(const ValidationResult& result);

}  // namespace alidade
