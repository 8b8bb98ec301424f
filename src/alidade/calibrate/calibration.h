// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "alidade/adjust/board/errors.h"
#include "alidade/adjust/board/fit.h"
#include "alidade/calibrate/choose/choice.h"
#include "alidade/calibrate/clean/dropped.h"
#include "alidade/calibrate/judge/judge.h"
#include "alidade/calibrate/uncertainty/uncertainty.h"
#include "alidade/camera/any_camera.h"
#include "alidade/core/diagnosis.h"

namespace alidade {

/// A calibrated camera, and what is known about it.
struct Calibration {
  Fit fit = {};                           ///< one camera; views in order of image name and board
  Dropped dropped = {};                   ///< corners and views that were given and are not in the fit
  Choice choice = {};                     ///< how the fit was found
  Uncertainty uncertainty = {};           ///< how accurate the camera is
  std::vector<Diagnosis> diagnoses = {};  ///< what is wrong, failures first
  DomainCertificate domain = {};          ///< where the camera is one-to-one

  /// Created by each call.
  [[nodiscard]] AnyCamera camera() const;
  [[nodiscard]] ImageSize imageSize() const { return onlyCamera(fit).size; }
  [[nodiscard]] Verdict verdict() const { return verdictOf(diagnoses); }
  /// False if any diagnosis is a failure: the parameters are then not to be used.
  [[nodiscard]] bool isUsable() const { return verdict() != Verdict::kNo; }
};

/// Judges everything except `diagnoses`; see judge(const Evidence&).
/// @param tolerance_px  see CalibratorOptions
[[nodiscard]] std::vector<Diagnosis> judge(const Calibration& calibration, double tolerance_px = 1);

/// How a view of a calibration came out.
struct ViewSummary {
  std::string image;
  std::size_t board = 0;  ///< index into Fit::boards
  int num_corners = 0;    ///< used, outliers left out
  int num_outliers = 0;
  double rms_px = 0;  ///< sqrt(mean over used corners of dx^2 + dy^2)
  double max_error_px = 0;
};

/// One per view of the fit.
[[nodiscard]] std::vector<ViewSummary> viewSummaries(const Calibration& calibration);

}  // namespace alidade
