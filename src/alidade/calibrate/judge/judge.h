// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "alidade/adjust/fit.h"
#include "alidade/calibrate/choose/choice.h"
#include "alidade/calibrate/clean/dropped.h"
#include "alidade/calibrate/uncertainty/uncertainty.h"
#include "alidade/camera/any_camera.h"
#include "alidade/core/diagnosis.h"

namespace alidade {

/// What a calibration is judged by.
struct Evidence {
  const Fit& fit;  ///< of one camera and one board
  const Dropped& dropped;
  const Choice& choice;
  const Uncertainty& uncertainty;
  const DomainCertificate& domain;
  const AnyCamera& camera;  ///< that of the fit
  double tolerance_px;      ///< see CalibratorOptions

  /// Errors over what neighbouring corners differ by: 1 for noise alone, more where they vary smoothly. NaN
  /// without neighbours.
  [[nodiscard]] double smoothness() const;
};

/// Everything that is wrong with a calibration, failures first; pure judgement, no estimation.
///
/// A failure makes the answer wrong or meaningless whatever the tolerance. Every other diagnosis states its
/// effect in pixels, from which its severity follows by severityOf().
[[nodiscard]] std::vector<Diagnosis> judge(const Evidence& evidence);

}  // namespace alidade
