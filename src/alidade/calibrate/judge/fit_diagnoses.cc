// SPDX-License-Identifier: MIT
#include <string>
#include <vector>

#include "alidade/adjust/board/errors.h"
#include "alidade/calibrate/judge/diagnoses.h"
#include "alidade/core/number_text.h"

namespace alidade::detail {
namespace {

// True if the errors are far larger than those of corners in sharp images.
bool isMisfit(const Evidence& of) {
  constexpr double kMisfit = 0.0005;  // of the image diagonal
  // Weighted, because corners with a large stated standard deviation are no misfit.
  return weightedRms(of.fit) > kMisfit * 2 * halfDiagonal(of);
}

void notConverged(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  if (of.fit.summary.termination == Termination::kConverged) return;
  diagnoses.push_back({.id = "not_converged",
                       .cause = "the solver stopped before it reached the optimum",
                       .evidence = of.fit.summary.reason,
                       .next_step = "check the images with the largest errors"});
}

void notSettled(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  if (of.choice.is_settled) return;
  diagnoses.push_back({.id = "not_settled",
                       .cause = "the views have no stable solution",
                       .evidence = "each fit changes which corners are outliers",
                       .next_step = "check the images with the largest errors"});
}

void parameterAtLimit(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  for (const FitParam& param : of.fit.summary.at_limit) {
    const auto i = static_cast<std::size_t>(param.index);
    diagnoses.push_back(
        {.id = "parameter_at_limit",
         .cause = std::string(of.camera.parameterNames()[i]) + " is at the limit of its range",
         .evidence = numberText("%g", of.camera.parameters()[i]),
         .next_step = "use a model that suits the lens"});
  }
}

void misfit(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  if (!isMisfit(of)) return;
  const double rms_px = weightedRms(of.fit);
  addByEffect(
      of,
      {.id = "misfit",
       .cause = "the errors are far larger than corner noise: wrong board, wrong model, blur or motion",
       .evidence = "RMS " + numberText("%.3g", rms_px) + " px",
       .next_step = "check the board's size and flatness, and the images with the largest errors"},
      1.73 * rms_px,  // 95 % of the errors of two coordinates
      diagnoses);
}

void modelTooLean(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  if (!of.choice.better_model) return;
  const BetterModel& better = *of.choice.better_model;
  addByEffect(of,
              {.id = "model_too_lean",
               .cause = "the lens has distortion that " + std::string(of.camera.modelId()) + " lacks",
               .evidence = better.id + " reduces the RMS from " + numberText("%.3g", better.lean_rms_px) +
                           " to " + numberText("%.3g", better.rms_px) + " px",
               .next_step = "use --model " + better.id},
              effectOfCamera(of, AnyCamera::make(better.id, better.params)), diagnoses);
}

void lensDeviates(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  if (!of.uncertainty.accuracy || of.choice.better_model || isMisfit(of)) return;
  const double deviation_px = of.uncertainty.accuracy->deviation_px;
  if (deviation_px == 0) return;
  addByEffect(of,
              {.id = "lens_deviates",
               .cause = "the lens deviates from " + std::string(of.camera.modelId()) + " by up to " +
                        numberText("%.2g", deviation_px) + " px",
               .evidence = "included in the accuracy",
               .next_step = of.choice.model ? "accept this error; no allowed model predicts corners better"
                                            : "try --model auto"},
              deviation_px, diagnoses);
}

}  // namespace

void diagnoseFit(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  for (const auto& diagnose :
       {notConverged, notSettled, parameterAtLimit, misfit, modelTooLean, lensDeviates})
    diagnose(of, diagnoses);
}

}  // namespace alidade::detail
