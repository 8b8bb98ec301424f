// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "alidade/adjust/board/fit.h"
#include "alidade/calibrate/start/reports.h"
#include "alidade/calibrate/uncertainty/uncertainty.h"
#include "alidade/camera/any_camera.h"
#include "alidade/camera/image_domain.h"
#include "alidade/core/diagnosis.h"

namespace alidade::detail {

/// Everything that a calibration is judged by, and its diagnoses so far.
struct Evidence {
  const Fit& fit;  ///< of one camera
  const Dropped& dropped;
  const Choice& choice;
  const Uncertainty& uncertainty;
  const DomainCertificate& domain;
  AnyCamera camera;     ///< that of the fit
  double tolerance_px;  ///< see CalibratorOptions
  std::vector<Diagnosis> diagnoses = {};

  /// True if successive views of one camera have similar errors beyond their noise.
  [[nodiscard]] bool isSeries() const {
    return uncertainty.by_views && uncertainty.by_views->serial_factor > 1 && uncertainty.isNoiseExceeded() &&
           !uncertainty.two_cameras;
  }
  void add(Diagnosis diagnosis) { diagnoses.push_back(std::move(diagnosis)); }
  /// Adds it with the severity of its effect, at most `worst`.
  void add(Diagnosis diagnosis, double effect_px, Severity worst = Severity::kFailure);
};

/// Next step for a series of views whose errors are similar.
inline constexpr const char* kBetterSeries =
    "take photographs, or a longer video: hold still in each place, without autofocus and stabilisation";

// Effects, px: the largest displacement of a far point over the covered pixels after alignment by the best
// rotation. NaN if nothing is covered.

/// Effect of a change of the parameters, to first order.
[[nodiscard]] double effectOfStep(const Evidence& of, std::span<const double> params_step);
/// Effect of replacing the camera by a different one.
[[nodiscard]] double effectOfCamera(const Evidence& of, const AnyCamera& other);
/// True if the views hardly determine the focal length.
[[nodiscard]] bool isFocalUnknown(const Evidence& of);
/// Half the image diagonal, px.
[[nodiscard]] double halfDiagonal(const Evidence& of);

// Each function adds the diagnoses that apply; for a further one see CONTRIBUTING.md.

/// Diagnoses the fit as a whole and the parameters of the lens.
void diagnoseLens(Evidence& of);
/// Diagnoses single views, errors common to all views, and unexpected differences between views.
void diagnoseViews(Evidence& of);
void diagnoseBoards(Evidence& of);

/// All problems found with a calibration, failures first; pure judgement, no estimation.
///
/// A failure makes the answer wrong or meaningless whatever the tolerance. Other diagnoses have the severity
/// of their row in kDiagnosisKinds, or of their effect in pixels by severityOf().
[[nodiscard]] std::vector<Diagnosis> judge(Evidence evidence);

}  // namespace alidade::detail
