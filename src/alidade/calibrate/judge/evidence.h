// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/board/fit.h"
#include "alidade/calibrate/start/reports.h"
#include "alidade/calibrate/uncertainty/uncertainty.h"
#include "alidade/camera/any_camera.h"
#include "alidade/core/diagnosis.h"

namespace alidade::detail {

/// Everything needed to judge a calibration.
struct Evidence {
  const Fit& fit;  ///< of one camera
  const Dropped& dropped;
  const Choice& choice;
  const Uncertainty& uncertainty;
  const DomainCertificate& domain;
  const AnyCamera& camera;  ///< that of the fit
  double tolerance_px;      ///< see CalibratorOptions
};

/// Adds a diagnosis with the severity of its effect, at most `worst`.
void addByEffect(const Evidence& of, Diagnosis diagnosis, double effect_px, std::vector<Diagnosis>& diagnoses,
                 Severity worst = Severity::kFailure);

// Effects, px: the largest displacement of a far point over the covered pixels after alignment by the best
// rotation. NaN if nothing is covered.

/// Effect of a change of the parameters, to first order.
[[nodiscard]] double effectOfStep(const Evidence& of, const Eigen::VectorXd& params_step);
/// Effect of replacing the camera by a different one.
[[nodiscard]] double effectOfCamera(const Evidence& of, const AnyCamera& other);
/// The stated accuracy where boards were seen.
[[nodiscard]] double coveredError(const Evidence& of);
/// Half the image diagonal, px.
[[nodiscard]] double halfDiagonal(const Evidence& of);

}  // namespace alidade::detail
