// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/board/fit.h"
#include "alidade/calibrate/choose/choice.h"
#include "alidade/calibrate/clean/dropped.h"
#include "alidade/calibrate/uncertainty/uncertainty.h"
#include "alidade/camera/any_camera.h"
#include "alidade/core/diagnosis.h"

namespace alidade {

/// What a calibration is judged by.
struct Evidence {
  const Fit& fit;  ///< of one camera
  const Dropped& dropped;
  const Choice& choice;
  const Uncertainty& uncertainty;
  const DomainCertificate& domain;
  const AnyCamera& camera;  ///< that of the fit
  double tolerance_px;      ///< see CalibratorOptions
};

/// Everything that is wrong with a calibration, failures first; pure judgement, no estimation.
///
/// A failure makes the answer wrong or meaningless whatever the tolerance. Every other diagnosis states its
/// effect in pixels, from which its severity follows by severityOf().
[[nodiscard]] std::vector<Diagnosis> judge(const Evidence& evidence);

// Each adds its diagnosis if there is a reason for it.

// The fit and its errors.
void notConverged(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void notSettled(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void parameterAtLimit(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void misfit(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void modelTooLean(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void lensDeviates(const Evidence& of, std::vector<Diagnosis>& diagnoses);

// The camera, and what the views do not determine.
void cornersOutsideDomain(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void foldsInImage(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void pixelsWithoutRay(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void principalPointOutside(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void oddAspect(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void undetermined(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void inaccurate(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void poorCoverage(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void illConditioned(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void ambiguousOptimum(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void centreMoves(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void focusBreathes(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void cornersBiased(const Evidence& of, std::vector<Diagnosis>& diagnoses);

// The board.
void bentBoard(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void unevenBoard(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void bendIgnored(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void bendUnknown(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void boardNotSquare(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void boardGraded(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void boardTwisted(const Evidence& of, std::vector<Diagnosis>& diagnoses);

// Corners and views.
void fewViews(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void outliers(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void viewsLeftOut(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void viewsDisagree(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void twoCamerasMixed(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void repeatedViews(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void influentialViews(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void mirroredViews(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void focalChanged(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void rollingShutter(const Evidence& of, std::vector<Diagnosis>& diagnoses);

/// Adds a diagnosis with the severity of its effect, at most `worst`.
void addByEffect(const Evidence& of, Diagnosis diagnosis, double effect_px, std::vector<Diagnosis>& diagnoses,
                 Severity worst = Severity::kFailure);

// Effects, px: the largest displacement of a far point over the covered pixels, after alignment by the best
// rotation. NaN if nothing is covered.

/// Of a change of the parameters, to first order.
[[nodiscard]] double effectOfStep(const Evidence& of, const Eigen::VectorXd& params_step);
/// Of another camera in place of this one.
[[nodiscard]] double effectOfCamera(const Evidence& of, const AnyCamera& other);
/// The stated accuracy where boards were seen.
[[nodiscard]] double coveredError(const Evidence& of);
/// Half the image diagonal, px.
[[nodiscard]] double halfDiagonal(const Evidence& of);

}  // namespace alidade
