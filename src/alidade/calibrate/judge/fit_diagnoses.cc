// SPDX-License-Identifier: MIT
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "alidade/adjust/errors.h"
#include "alidade/calibrate/judge/diagnoses.h"
#include "alidade/core/number_text.h"

namespace alidade {

void notConverged(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  if (of.fit.summary.termination != Termination::kConverged) {
    diagnoses.push_back({.severity = Severity::kFailure,
                         .id = "not_converged",
                         .cause = "the solver stopped before the optimum",
                         .evidence = of.fit.summary.reason,
                         .next_step = "look for wrong views; the worst ones are listed"});
  }
}

void notSettled(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  if (!of.choice.is_settled) {
    diagnoses.push_back({.severity = Severity::kFailure,
                         .id = "not_settled",
                         .cause = "there is no stable answer to these views",
                         .evidence = "each fit changes which corners look like outliers",
                         .next_step = "look for wrong views; the worst ones are listed"});
  }
}

void parameterAtLimit(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  for (const FitParam& param : of.fit.summary.at_limit) {
    const auto i = static_cast<std::size_t>(param.index);
    diagnoses.push_back({.severity = Severity::kWarning,
                         .id = "parameter_at_limit",
                         .cause = "the model would have to bend farther than it can",
                         .evidence = std::string(of.camera.parameterNames()[i]) +
                                     " has come to the end of its range, " +
                                     numberText("%g", of.camera.parameters()[i]),
                         .next_step = "use a model that suits the lens"});
  }
}

void misfit(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  // RMS as a share of the image's diagonal: a wrong model or board above the first, a doubtful one above the
  // second.
  constexpr double kMisfitNo = 0.002;
  constexpr double kMisfitWarn = 0.0005;
  const ImageSize size = onlyCamera(of.fit).size;
  const double diagonal = std::hypot(size.width, size.height);
  // Weighted: corners that say themselves that they are poor are no misfit.
  const double share = weightedRms(of.fit) / diagonal;
  if (!(share <= kMisfitWarn)) {
    diagnoses.push_back(
        {.severity = share <= kMisfitNo ? Severity::kWarning : Severity::kFailure,
         .id = "misfit",
         .cause = "the errors are more than corners' noise; the lens does not follow the model, the board "
                  "is not flat, or images are blurred",
         .evidence = "RMS " + numberText("%.3g", weightedRms(of.fit)) + " px",
         .next_step = "try another model; check that the board is flat and rigid; look at the worst views"});
  }
}

void modelTooLean(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  // Where the lens errs in the same way in all views by more than this, px, the model does not suit it at
  // all.
  constexpr double kBiasHarmfulPx = 0.5;
  if (of.choice.better_model) {
    diagnoses.push_back(
        {.severity = Severity::kFailure,
         .id = "model_too_lean",
         .cause = "the lens has distortion that this model lacks, and its other parameters are bent to make "
                  "up for it",
         .evidence = of.choice.better_model->id + " explains the same corners with an RMS of " +
                     numberText("%.3g", of.choice.better_model->rms_px) + " px instead of " +
                     numberText("%.3g", of.choice.better_model->lean_rms_px) + " px",
         .next_step = "use --model " + of.choice.better_model->id});
  }
  if (!of.choice.better_model && of.uncertainty.hasBias()) {
    diagnoses.push_back(
        {.severity =
             of.uncertainty.image_bias.rms_px > kBiasHarmfulPx ? Severity::kFailure : Severity::kWarning,
         .id = "model_too_lean",
         .cause = "the lens bends light in a way that this model cannot follow",
         .evidence = "all views err in the same way at the same place of the image, by " +
                     numberText("%.2g", of.uncertainty.image_bias.rms_px) + " px (" +
                     numberText("%.1f", of.uncertainty.image_bias.z) + " sigma)",
         .next_step = "use --model auto, or a model with more parameters; else expect this error"});
  }
}

void unsharp(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  constexpr double kUnsharpPx = 0.3;  // sharp images give corners to 0.02 to 0.15 px
  // A lens that is fitted badly makes neighbours differ too.
  if (of.uncertainty.local_sigma_px > kUnsharpPx && !of.choice.better_model && !of.uncertainty.hasBias()) {
    diagnoses.push_back({.severity = Severity::kWarning,
                         .id = "unsharp",
                         .cause = "corners are found badly: the images are unsharp, noisy or coarse",
                         .evidence = "neighbouring corners differ by noise of " +
                                     numberText("%.2g", of.uncertainty.local_sigma_px) + " px an axis",
                         .next_step = "focus on the board's distance, give more light and shorter exposure, "
                                      "and clean the lens"});
  }
}

void systematicErrors(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  // Errors this many times as large as what neighbouring corners differ by are not noise alone.
  constexpr double kSmoothWarn = 1.5;
  constexpr double kSmallRmsPx = 0.02;  // below this, smooth or not, nobody is hurt
  const double smoothness = of.smoothness();
  if (smoothness > kSmoothWarn && weightedRms(of.fit) > kSmallRmsPx) {
    diagnoses.push_back(
        {.severity = Severity::kWarning,
         .id = "systematic_errors",
         .cause = "errors vary smoothly over the board and are not noise alone, so the stated sigmas are too "
                  "small",
         .evidence =
             "they are " + numberText("%.1f", smoothness) + " times what neighbouring corners differ by",
         .next_step =
             "check that the board is flat and the images are sharp; a richer model may suit the lens"});
  }
}

void noiseExceeded(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  if (of.uncertainty.isNoiseExceeded()) {
    diagnoses.push_back(
        {.severity = Severity::kNote,
         .id = "noise_exceeded",
         .cause =
             "the views disagree about the camera by more than corners' noise explains, so the sigmas by "
             "noise are too small; those by the views and those of the projection allow for it",
         .evidence = numberText("%.1f", std::sqrt(of.uncertainty.by_views->excess)) + " times as much (" +
                     numberText("%.0f", of.uncertainty.by_views->excess_sigmas) + " sigma)",
         .next_step = "look for blur, a board that moves or is bent otherwise in each view, and for a model "
                      "that suits the lens"});
  }
}

}  // namespace alidade
