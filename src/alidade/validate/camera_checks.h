// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "alidade/core/diagnosis.h"
#include "alidade/files/camera_source.h"
#include "alidade/record/camera_record.h"
#include "alidade/validate/footage/footage_judgement.h"
#include "alidade/validate/held_out/held_out_images.h"

namespace alidade {

/// The numbers that a check computed or compared with, by name. Names end in the unit: "fx_px"; shares have
/// none.
using CheckValues = std::vector<std::pair<std::string, double>>;

/// A question that was asked of a camera file, and the answer.
struct FileCheck {
  Severity severity = Severity::kPass;
  DiagnosisId id;
  std::string message;                   ///< the answer, with value and limit
  CheckValues values = {};               ///< of the message
  std::string slip = {};                 ///< the id of the slip behind a misfit
  std::optional<AnyCamera> mended = {};  ///< the camera without the slip; nothing: none is known
};

/// A diagnosis as a check without numbers. A next step is a line of its own: "\n  next: ...".
[[nodiscard]] FileCheck fileCheck(const Diagnosis& diagnosis);

/// "trustworthy, within 0.99 px (95 %) over 40 % of the image": the verdict and, if known, the accuracy.
[[nodiscard]] std::string calibrationText(const CalibrationRecord& stated);

/// Checks the numbers of a camera: focal lengths, aspect, principal point, tangential coefficients, and what
/// share of the image has a ray. Checks what the record states beside them: the domain, self-check points,
/// the covariance, the uncertainty of pixels, and the verdict of the calibration. What is not stated is
/// not checked.
/// @param is_size_guessed   the file does not state `image_size`; see sizeAround()
/// @param rectified_center  the principal point of the rectified images, px, if the file states it
[[nodiscard]] std::vector<FileCheck> checkCamera(
    const CameraRecord& record, bool is_size_guessed = false,
    const std::optional<Eigen::Vector2d>& rectified_center = std::nullopt);

/// The image size, px, for checking a camera whose file states none: its principal point is the
/// centre.
[[nodiscard]] ImageSize sizeAround(const AnyCamera& camera);

/// What was found out about a camera of a file.
struct CameraJudgement {
  std::string name;                                   ///< selects it after FILE#: its name, or its number
  std::optional<AnyCamera> camera = {};               ///< nothing: its model is not supported
  std::optional<ImageSize> image_size = {};           ///< px; nothing: the file does not state it
  std::optional<CalibrationRecord> calibration = {};  ///< of an Alidade camera file
  std::vector<FileCheck> checks = {};                 ///< at least one
  std::optional<HeldOutJudgement> held_out = {};      ///< what images say of it, if there are any
  std::optional<FootageJudgement> footage = {};       ///< what footage says of it, if there is some
  bool can_show_slips = false;  ///< the file itself, or what it was compared with, can show a wrong number

  /// The most severe of its checks.
  [[nodiscard]] Severity severity() const;
};

/// What was found out about a file.
struct FileJudgement {
  std::string file;                           ///< as given; may end in "#NAME"
  std::string format = {};                    ///< id; empty: it cannot be read
  std::string error = {};                     ///< why it cannot be read; empty: it can
  std::vector<CameraJudgement> cameras = {};  ///< in the file's order; none if it cannot be read
  std::vector<FileCheck> rig_checks = {};     ///< of where the cameras are; none if the file does not say it

  /// The most severe of all checks; a failure if the file cannot be read.
  [[nodiscard]] Severity severity() const;
};

/// Checks a camera of `file` by itself.
[[nodiscard]] CameraJudgement judgeCamera(const StatedCamera& stated, const std::string& file);

/// Checks where the cameras of a file are to each other, the verdict on their rig, and its covariance;
/// nothing for a file that is no rig of supported cameras. What is not stated is not checked.
[[nodiscard]] std::vector<FileCheck> checkRig(const CameraSource& source);

/// The check of a covariance that contradicts neither itself nor the standard deviations beside it.
/// @param what  "the covariance"
/// @param std   the name of the standard deviations
[[nodiscard]] FileCheck covarianceCheck(DiagnosisId id, const std::string& what, bool is_semidefinite,
                                        bool is_consistent, const std::string& std);

/// The check that repeats the verdict of a calibration.
[[nodiscard]] FileCheck verdictCheck(DiagnosisId id, Verdict verdict, std::string message);

/// `message` without the path that it begins with: "cam.yaml:4: fx: found ..." becomes "line 4: fx: found
/// ...".
[[nodiscard]] std::string withoutPath(const std::string& message, const std::string& file);

}  // namespace alidade
