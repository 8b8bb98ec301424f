// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "alidade/adjust/lens_prior.h"
#include "alidade/calibrate/ambiguity_finding.h"
#include "alidade/calibrate/calibration_result.h"
#include "alidade/calibrate/data_findings.h"
#include "alidade/camera/lens_shapes.h"
#include "alidade/core/number_text.h"

namespace alidade {
namespace {

using Severity = Finding::Severity;

// Even a perfect fit does not make a focal length certain; noise is taken to be at least this, px.
constexpr double kNoiseFloorPx = 0.05;
// One sigma of the focal length as a share of it: above the first the answer is no, above the second a
// warning.
constexpr double kFocalUnknown = 0.02;
constexpr double kFocalWeak = 0.005;
// Views within this of fronto-parallel tell focal length from distance badly.
constexpr double kSmallTiltDeg = 15.0;
// RMS as a share of the image's diagonal: a wrong model or board above the first, a doubtful one above the
// second.
constexpr double kMisfitNo = 0.002;
constexpr double kMisfitWarn = 0.0005;
// Errors this many times as large as what neighbouring corners differ by are not noise alone.
constexpr double kSmoothWarn = 1.5;
constexpr double kSmallRmsPx = 0.02;  // below this, smooth or not, nobody is hurt
constexpr int kFewViews = 8;
// Where the lens errs in the same way in all views by more than this, px, the model does not suit it at all.
constexpr double kBiasHarmfulPx = 0.5;
// A pixel known to one sigma no better than this is a guess, and this share of the image may be one.
constexpr double kGuessPx = 1.0;
constexpr double kGuessedShare = 0.1;
// Sharp images give corners to 0.02 to 0.15 px.
constexpr double kUnsharpPx = 0.3;
// A board bent by this share of its size is no longer the paraboloid that two numbers describe.
constexpr double kBentShare = 0.005;

double degrees(double radians) {
  return radians * 180 / std::numbers::pi;
}

// Angles between the image plane and the board, degrees, ascending.
std::vector<double> tiltsDeg(const CalibrationResult& result) {
  std::vector<double> tilts;
  for (const ViewResult& view : result.views) {
    const double c = std::abs(view.camera_from_board.rotation.matrix()(2, 2));
    tilts.push_back(degrees(std::acos(std::min(1.0, c))));
  }
  std::sort(tilts.begin(), tilts.end());
  return tilts;
}

// Relative one sigma of the focal lengths on the axis, the stated one and that by noise with corners no
// better than the noise floor, whichever is larger.
double relativeFocalStd(const CalibrationResult& result) {
  if (!result.covariance) return std::numeric_limits<double>::infinity();
  const Eigen::MatrixXd J = axisFocalJacobian(result.camera);
  const Eigen::Vector2d focal = axisFocal(result.camera);
  const auto largest = [&](const Eigen::MatrixXd& covariance) {
    const Eigen::Vector2d std = (J * covariance * J.transpose()).diagonal().cwiseMax(0).cwiseSqrt();
    return std.cwiseQuotient(focal).maxCoeff();
  };
  const double inflate = std::max(1.0, kNoiseFloorPx / result.coordinate_sigma_px);
  return std::max(inflate * largest(*result.covariance), largest(result.statedCovariance()));
}

void judgeObservability(const CalibrationResult& result, std::vector<Finding>& findings) {
  const double focal_std = relativeFocalStd(result);
  // Where the focal length is unknown, noise feigns tilts in single views; the median keeps away from those.
  const std::vector<double> tilts = tiltsDeg(result);
  const double tilt = tilts[tilts.size() / 2];
  const bool is_unknown = !(focal_std < kFocalUnknown);
  const bool is_parallel = tilts[tilts.size() - 2] < kSmallTiltDeg;
  if ((is_unknown && tilt < kSmallTiltDeg) || is_parallel) {
    // That the stated sigma is small helps little: it takes the model for the lens.
    findings.push_back(
        {.severity = is_unknown ? Severity::kFailure : Severity::kWarning,
         .id = "fronto_parallel",
         .cause = "the board is nearly parallel to the image in most views, so focal length and distance "
                  "cannot be told apart",
         .evidence = "median tilt " + numberText("%.1f", tilt) + " degrees" +
                     (std::isfinite(focal_std)
                          ? ", focal length known to " + numberText("%.2g", 100 * focal_std) + " %"
                          : ""),
         .next_step = "add views with the board tilted by 20 to 50 degrees, about both of its axes"});
  } else if (!result.covariance) {
    findings.push_back(
        {.severity = Severity::kFailure,
         .id = "unobservable",
         .cause = "these views leave some combination of the parameters undetermined",
         .evidence =
             "condition " + numberText("%.1g", result.scaled_condition) + " of the scaled information",
         .next_step =
             "add views with other tilts, distances and places in the image, or use a smaller model"});
  } else if (is_unknown || focal_std > kFocalWeak) {
    findings.push_back(
        {.severity = is_unknown ? Severity::kFailure : Severity::kWarning,
         .id = "focal_uncertain",
         .cause = "the focal length is not known well",
         .evidence = "one sigma is " + numberText("%.2g", 100 * focal_std) +
                     " % of it (corners taken as no better than 0.05 px)",
         .next_step = "add views with the board tilted by 20 to 50 degrees and filling the image"});
  }
  if (result.views.size() < kFewViews) {
    findings.push_back({.severity = Severity::kWarning,
                        .id = "few_views",
                        .cause = "there are few views to notice a mistake by",
                        .evidence = std::to_string(result.views.size()) + " in use",
                        .next_step = "use at least " + std::to_string(kFewViews) + ", better 15 to 30"});
  }
}

// Where no prior could hold a lens together without contradicting the corners.
void judgeRunaway(const CalibrationResult& result, std::vector<Finding>& findings) {
  const LensScale scale = lensScale(result.camera.modelId(), result.camera, result.image_size);
  const auto params = result.camera.parameters();
  std::string names;
  for (std::size_t i = 0; i < params.size(); ++i) {
    const bool is_held =
        std::find(result.held.begin(), result.held.end(), static_cast<int>(i)) != result.held.end();
    if (is_held || scale.distance(params, i) <= kRunawaySizes) continue;
    names += (names.empty() ? "" : ", ") + std::string(result.camera.parameterNames()[i]) + " " +
             numberText("%.3g", params[i]);
  }
  if (names.empty()) return;
  findings.push_back({.severity = Severity::kWarning,
                      .id = "ill_conditioned",
                      .cause =
                          "lens parameters make up for one another and went to numbers that no lens has; "
                          "where no corner was seen the model is not to be trusted, whatever its sigmas",
                      .evidence = names,
                      .next_step = "use a smaller model, or add views that reach the image's corners"});
}

void judgeConditioning(const CalibrationResult& result, std::vector<Finding>& findings) {
  const WeakPrior& held = result.weak_prior;
  if (held.isNone()) {
    judgeRunaway(result, findings);
    return;
  }
  std::string changes;
  for (const int i : held.least_known) {
    const auto at = static_cast<std::size_t>(i);
    changes += (changes.empty() ? "" : ", ") + std::string(result.camera.parameterNames()[at]) + " from " +
               numberText("%.3g", held.free_params[at]) + " to " +
               numberText("%.3g", result.camera.parameters()[at]);
  }
  findings.push_back(
      {.severity = Severity::kWarning,
       .id = "ill_conditioned",
       .cause = "these views leave the lens undetermined, so it is held by the weakest prior that keeps it "
                "within reason; single parameters mean little, and projections are as good as their sigmas",
       .evidence = "a prior of " + numberText("%g", held.width) +
                   " natural sizes, by which a parameter moves the image's corner by half the diagonal, "
                   "changed " +
                   changes,
       .next_step = "use a smaller model, or add views that reach the image's corners"});
}

// Corners of the image that no board reached hold what the model makes of the rest. A few are usual.
void judgeReach(const CalibrationResult& result, std::vector<Finding>& findings) {
  if (!result.projection_far) return;
  const UncertaintyGrid& grid = *result.projection_far;
  std::size_t num_rays = 0;
  std::size_t num_guessed = 0;
  for (const double std_px : grid.std_px) {
    if (std::isnan(std_px)) continue;
    ++num_rays;
    if (std_px > kGuessPx) ++num_guessed;
  }
  const double share =
      static_cast<double>(num_guessed) / static_cast<double>(std::max<std::size_t>(num_rays, 1));
  if (share <= kGuessedShare) return;
  findings.push_back(
      {.severity = Severity::kWarning,
       .id = "poor_coverage",
       .cause = "the views leave parts of the image to guesswork",
       .evidence = "one sigma of a projected point is above 1 px in " + numberText("%.0f", 100 * share) +
                   " % of the image, " + numberText("%.3g", grid.worst_px) + " px at (" +
                   numberText("%.0f", grid.worst_pixel.x()) + ", " +
                   numberText("%.0f", grid.worst_pixel.y()) + ")",
       .next_step = "take the view that is suggested as the next one, and others that fill the image to its "
                    "corners"});
}

void judgeDomain(const CalibrationResult& result, std::vector<Finding>& findings) {
  if (result.domain.full_image) return;
  std::string where;
  if (const auto& pixel = result.domain.pixel_without_ray) {
    where =
        ", pixel (" + numberText("%.1f", pixel->x()) + ", " + numberText("%.1f", pixel->y()) + ") has no ray";
  }
  if (!foldsInsideImage(result.domain)) {
    // A wide lens leaves the image's corners dark: no ray of its ends there.
    findings.push_back(
        {.severity = Severity::kWarning,
         .id = "pixels_without_ray",
         .cause = "the model ends inside the image",
         .evidence =
             numberText("%.0f", degrees(result.domain.cone.max_angle_rad)) + " degrees from the axis" + where,
         .next_step = "look whether the lens leaves these pixels dark; if it does not, use another model"});
    return;
  }
  findings.push_back(
      {.severity = Severity::kFailure,
       .id = "folds_in_image",
       .cause = "the distortion folds over inside the image",
       .evidence =
           numberText("%.0f", degrees(result.domain.cone.max_angle_rad)) + " degrees from the axis" + where,
       .next_step = "add views that reach the image's corners, or use a model that suits the lens"});
}

void judgeConvergence(const CalibrationResult& result, std::vector<Finding>& findings) {
  if (result.solver.termination != Termination::kConverged) {
    findings.push_back({.severity = Severity::kFailure,
                        .id = "not_converged",
                        .cause = "the solver stopped before the optimum",
                        .evidence = result.solver.reason,
                        .next_step = "look for wrong views; the worst ones are listed"});
  }
  if (!result.is_settled) {
    findings.push_back({.severity = Severity::kFailure,
                        .id = "not_settled",
                        .cause = "there is no stable answer to these views",
                        .evidence = "each fit changes which corners look like outliers",
                        .next_step = "look for wrong views; the worst ones are listed"});
  }
}

void judgeLimits(const CalibrationResult& result, std::vector<Finding>& findings) {
  for (const FitParam& param : result.solver.at_limit) {
    const auto i = static_cast<std::size_t>(param.index);
    findings.push_back({.severity = Severity::kWarning,
                        .id = "parameter_at_limit",
                        .cause = "the model would have to bend farther than it can",
                        .evidence = std::string(result.camera.parameterNames()[i]) +
                                    " has come to the end of its range, " +
                                    numberText("%g", result.camera.parameters()[i]),
                        .next_step = "use a model that suits the lens"});
  }
}

void judgeMisfit(const CalibrationResult& result, std::vector<Finding>& findings) {
  const double diagonal = std::hypot(result.image_size.width, result.image_size.height);
  // Weighted: corners that say themselves that they are poor are no misfit.
  const double share = result.weighted_rms_px / diagonal;
  if (!(share <= kMisfitWarn)) {
    findings.push_back(
        {.severity = share <= kMisfitNo ? Severity::kWarning : Severity::kFailure,
         .id = "misfit",
         .cause = "the errors are more than corners' noise; the lens does not follow the model, the board "
                  "is not flat, or images are blurred",
         .evidence = "RMS " + numberText("%.3g", result.weighted_rms_px) + " px",
         .next_step = "try another model; check that the board is flat and rigid; look at the worst views"});
  }
}

void judgeModel(const CalibrationResult& result, std::vector<Finding>& findings) {
  if (result.better_model) {
    findings.push_back(
        {.severity = Severity::kFailure,
         .id = "model_too_lean",
         .cause = "the lens has distortion that this model lacks, and its other parameters are bent to make "
                  "up for it",
         .evidence = result.better_model->id + " explains the same corners with an RMS of " +
                     numberText("%.3g", result.better_model->rms_px) + " px instead of " +
                     numberText("%.3g", result.better_model->lean_rms_px) + " px",
         .next_step = "use --model " + result.better_model->id});
  }
  if (!result.better_model && result.hasBias()) {
    findings.push_back(
        {.severity = result.image_bias.rms_px > kBiasHarmfulPx ? Severity::kFailure : Severity::kWarning,
         .id = "model_too_lean",
         .cause = "the lens bends light in a way that this model cannot follow",
         .evidence = "all views err in the same way at the same place of the image, by " +
                     numberText("%.2g", result.image_bias.rms_px) + " px (" +
                     numberText("%.1f", result.image_bias.z) + " sigma)",
         .next_step = "use --model auto, or a model with more parameters; else expect this error"});
  }
}

void judgeSharpness(const CalibrationResult& result, std::vector<Finding>& findings) {
  // A lens that is fitted badly makes neighbours differ too.
  if (result.local_sigma_px > kUnsharpPx && !result.better_model && !result.hasBias()) {
    findings.push_back({.severity = Severity::kWarning,
                        .id = "unsharp",
                        .cause = "corners are found badly: the images are unsharp, noisy or coarse",
                        .evidence = "neighbouring corners differ by noise of " +
                                    numberText("%.2g", result.local_sigma_px) + " px an axis",
                        .next_step = "focus on the board's distance, give more light and shorter exposure, "
                                     "and clean the lens"});
  }
}

void judgeErrors(const CalibrationResult& result, std::vector<Finding>& findings) {
  const double smoothness = result.smoothness();
  if (smoothness > kSmoothWarn && result.weighted_rms_px > kSmallRmsPx) {
    findings.push_back(
        {.severity = Severity::kWarning,
         .id = "systematic_errors",
         .cause = "errors vary smoothly over the board and are not noise alone, so the stated sigmas are too "
                  "small",
         .evidence =
             "they are " + numberText("%.1f", smoothness) + " times what neighbouring corners differ by",
         .next_step =
             "check that the board is flat and the images are sharp; a richer model may suit the lens"});
  }
  if (result.isNoiseExceeded()) {
    findings.push_back(
        {.severity = Severity::kNote,
         .id = "noise_exceeded",
         .cause =
             "the views disagree about the camera by more than corners' noise explains, so the sigmas by "
             "noise are too small; those by the views and those of the projection allow for it",
         .evidence = numberText("%.1f", std::sqrt(result.by_views->excess)) + " times as much (" +
                     numberText("%.0f", result.by_views->excess_sigmas) + " sigma)",
         .next_step = "look for blur, a board that moves or is bent otherwise in each view, and for a model "
                      "that suits the lens"});
  }
}

void judgeBend(const CalibrationResult& result, std::vector<Finding>& findings) {
  if (result.shape.bend_share > kBentShare) {
    findings.push_back(
        {.severity = Severity::kWarning,
         .id = "bent_board",
         .cause = "the board is bent too much to be a paraboloid, which is what is allowed for",
         .evidence = "its middle stands out by " + numberText("%.2g", 100 * result.shape.bend_share) +
                     " % of its size",
         .next_step = "mount the board on something flat and rigid, and photograph it again"});
  }
  if (result.ignored_bend) {
    const BoardShape& bend = result.ignored_bend->shape;
    findings.push_back(
        {.severity = Severity::kWarning,
         .id = "bend_ignored",
         .cause = "the board is bent but was taken as flat; the stated uncertainty allows for it",
         .evidence = numberText("%.2g", 1e3 * bend.bend_x_m) + " mm from left to right and " +
                     numberText("%.2g", 1e3 * bend.bend_y_m) +
                     " mm from top to bottom; with the bend fx would change by " +
                     numberText("%.2g", result.ignored_bend->params_step(0)) + " px",
         .next_step = "use --board-shape auto, and a model that suits the lens"});
  }
  if (!result.shape.is_determined && result.shape.is_requested) {
    findings.push_back({.severity = Severity::kWarning,
                        .id = "bend_unknown",
                        .cause = "these views do not tell whether the board is bent, so it was taken as flat",
                        .evidence = {},
                        .next_step = "take more views, tilted both ways, of a board with three or more "
                                     "corners a side"});
  }
}

void judgePlausibility(const CalibrationResult& result, std::vector<Finding>& findings) {
  if (result.num_corners_outside > 0) {
    findings.push_back({.severity = Severity::kFailure,
                        .id = "corners_outside_domain",
                        .cause = "corners lie beyond the angle at which the distortion folds over",
                        .evidence = std::to_string(result.num_corners_outside) + " corners",
                        .next_step = "use a model that suits the lens"});
  }
  const auto params = result.camera.parameters();
  const bool is_centred = params[2] > 0 && params[2] < result.image_size.width && params[3] > 0 &&
                          params[3] < result.image_size.height;
  if (!is_centred) {
    findings.push_back(
        {.severity = Severity::kFailure,
         .id = "principal_point_outside",
         .cause = "the principal point lies outside the image",
         .evidence = "(" + numberText("%.0f", params[2]) + ", " + numberText("%.0f", params[3]) + ")",
         .next_step = "check that the images are neither cropped nor mixed from several cameras"});
  }
  const double aspect = params[0] / params[1];
  constexpr double kOddAspect = 1.03;
  if (std::max(aspect, 1 / aspect) > kOddAspect) {
    findings.push_back(
        {.severity = Severity::kWarning,
         .id = "odd_aspect",
         .cause = "pixels are not square, as those of almost all sensors are",
         .evidence = "fx / fy is " + numberText("%.3f", aspect),
         .next_step = "check whether the images were stretched and whether the board's squares are square"});
  }
}

}  // namespace

std::vector<Finding> judge(const CalibrationResult& result) {
  std::vector<Finding> findings;
  judgeConvergence(result, findings);
  judgeLimits(result, findings);
  judgeMisfit(result, findings);
  judgeModel(result, findings);
  judgeSharpness(result, findings);
  judgeErrors(result, findings);
  judgeBend(result, findings);
  judgePlausibility(result, findings);
  judgeObservability(result, findings);
  judgeConditioning(result, findings);
  judgeAmbiguity(result, findings);
  judgeDomain(result, findings);
  judgeReach(result, findings);
  judgeData(result, findings);
  std::stable_sort(findings.begin(), findings.end(),
                   [](const Finding& a, const Finding& b) { return a.severity > b.severity; });
  return findings;
}

}  // namespace alidade
