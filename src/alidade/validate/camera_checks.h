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

/// Numbers that a check computed or compared with, by name. Names end in the unit: "fx_px"; shares have none.
using CheckValues = std::vector<std::pair<std::string, double>>;

/// A question about a camera file, and the answer.
struct FileCheck {
  Severity severity = Severity::kPass;
  DiagnosisId id;
  std::string message;                   ///< the answer, with value and limit
  CheckValues values = {};               ///< of the message
  std::string slip = {};                 ///< id of the slip that explains a misfit
  std::optional<AnyCamera> mended = {};  ///< the camera without the slip; nothing if none is known
};

/// A diagnosis as a check without numbers. A next step is on its own line: "\n  next: ...".
[[nodiscard]] FileCheck fileCheck(const Diagnosis& diagnosis);

/// "trustworthy, within 0.99 px (95 %) over 40 % of the image": the verdict and, if known, the accuracy.
[[nodiscard]] std::string calibrationText(const CalibrationRecord& stated);

/// Checks the numbers of a camera: focal lengths, aspect, principal point, tangential coefficients, and the
/// share of the image that has a ray. Also checks what else the record states: domain, self-check points,
/// covariance, uncertainty of pixels, and the verdict of the calibration. Values that are not stated are not
/// checked.
/// @param is_size_guessed   the file does not state `image_size`; see sizeAround()
/// @param rectified_center  the principal point of the rectified images, px, if the file states it
[[nodiscard]] std::vector<FileCheck> checkCamera(
    const CameraRecord& record, bool is_size_guessed = false,
    const std::optional<Eigen::Vector2d>& rectified_center = std::nullopt);

/// The image size, px, for checking a camera whose file states none, chosen so that its principal point is
/// the centre.
[[nodiscard]] ImageSize sizeAround(const AnyCamera& camera);

/// Findings on one camera of a file.
struct CameraJudgement {
  std::string name;                                   ///< selects it after FILE#: its name, or its number
  std::optional<AnyCamera> camera = {};               ///< nothing if its model is not supported
  std::optional<ImageSize> image_size = {};           ///< px; nothing if the file does not state it
  std::optional<CalibrationRecord> calibration = {};  ///< of an Alidade camera file
  CameraName label = {};                              ///< that it states of itself, in such a file
  std::vector<FileCheck> checks = {};                 ///< at least one
  std::optional<HeldOutJudgement> held_out = {};      ///< findings from images, if there are any
  std::optional<FootageJudgement> footage = {};       ///< findings from footage, if there is any
  bool can_show_slips = false;  ///< the file itself, or the comparison, can show a wrong number

  /// The most severe of its checks.
  [[nodiscard]] Severity severity() const;
};

/// Findings on a file.
struct FileJudgement {
  std::string file;                           ///< as given; may end in "#NAME"
  std::string format = {};                    ///< id; empty if it cannot be read
  std::string error = {};                     ///< reason why it cannot be read; empty if it can
  std::vector<CameraJudgement> cameras = {};  ///< in the file's order; none if it cannot be read
  std::vector<FileCheck> rig_checks = {};     ///< of the camera poses; empty if the file states none

  /// The most severe of all checks; a failure if the file cannot be read.
  [[nodiscard]] Severity severity() const;
};

/// Checks a camera of `file` by itself.
[[nodiscard]] CameraJudgement judgeCamera(const StatedCamera& stated, const std::string& file);

/// Checks the poses of a rig's cameras, its verdict, and its covariance; empty if the file is no rig of
/// supported cameras. Values that are not stated are not checked.
[[nodiscard]] std::vector<FileCheck> checkRig(const CameraSource& source);

/// Checks that a covariance is valid and agrees with the standard deviations beside it.
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
