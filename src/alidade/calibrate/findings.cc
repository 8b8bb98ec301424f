// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "alidade/calibrate/calibration_result.h"
#include "alidade/calibrate/data_findings.h"
#include "alidade/calibrate/number_text.h"

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
// A board bent by this share of its size is no longer the paraboloid that two numbers describe.
constexpr double kBentShare = 0.005;

double degrees(double radians) {
  return radians * 180 / std::numbers::pi;
}

// Median angle between the image plane and the board, degrees. Where the focal length is unknown, noise
// feigns tilts in single views; the median keeps away from those.
double medianTiltDeg(const CalibrationResult& result) {
  std::vector<double> tilts;
  for (const ViewResult& view : result.views) {
    const double c = std::abs(view.camera_from_board.rotation.matrix()(2, 2));
    tilts.push_back(degrees(std::acos(std::min(1.0, c))));
  }
  const auto middle = tilts.begin() + static_cast<std::ptrdiff_t>(tilts.size() / 2);
  std::nth_element(tilts.begin(), middle, tilts.end());
  return *middle;
}

// Relative one sigma of the focal lengths with corners no better than the noise floor.
double relativeFocalStd(const CalibrationResult& result) {
  if (!result.covariance) return std::numeric_limits<double>::infinity();
  const double inflate = std::max(1.0, kNoiseFloorPx / result.coordinate_sigma_px);
  double largest = 0;
  for (int i = 0; i < 2; ++i) {
    largest =
        std::max(largest, result.parameterStd(i) / result.camera.parameters()[static_cast<std::size_t>(i)]);
  }
  return largest * inflate;
}

void judgeObservability(const CalibrationResult& result, std::vector<Finding>& findings) {
  const double focal_std = relativeFocalStd(result);
  const double tilt = medianTiltDeg(result);
  const bool is_unknown = !(focal_std < kFocalUnknown);
  if (is_unknown && tilt < kSmallTiltDeg) {
    findings.push_back(
        {.severity = Severity::kFailure,
         .id = "fronto_parallel",
         .message = "the board is nearly parallel to the image in most views (median tilt " +
                    numberText("%.1f", tilt) + " degrees): focal length and distance cannot be told apart",
         .next_step = "add views with the board tilted by 20 to 50 degrees, about both of its axes"});
  } else if (!result.covariance) {
    findings.push_back(
        {.severity = Severity::kFailure,
         .id = "unobservable",
         .message = "these views leave some combination of the parameters undetermined",
         .next_step =
             "add views with other tilts, distances and places in the image, or use a smaller model"});
  } else if (is_unknown || focal_std > kFocalWeak) {
    findings.push_back(
        {.severity = is_unknown ? Severity::kFailure : Severity::kWarning,
         .id = "focal_uncertain",
         .message = "the focal length is known to " + numberText("%.2g", 100 * focal_std) +
                    " % only (one sigma, corners taken as no better than 0.05 px)",
         .next_step = "add views with the board tilted by 20 to 50 degrees and filling the image"});
  }
  if (result.views.size() < kFewViews) {
    findings.push_back({.severity = Severity::kWarning,
                        .id = "few_views",
                        .message = std::to_string(result.views.size()) + " views are few",
                        .next_step = "use at least " + std::to_string(kFewViews) + ", better 15 to 30"});
  }
}

void judgeConditioning(const CalibrationResult& result, std::vector<Finding>& findings) {
  const WeakPrior& held = result.weak_prior;
  if (held.is_missing) {
    findings.push_back(
        {.severity = Severity::kWarning,
         .id = "ill_conditioned",
         .message = "these views do not determine the lens, and no lens of ordinary size explains them",
         .next_step = "add views that reach the image's corners, or use a smaller model"});
    return;
  }
  if (held.isNone()) return;
  std::string names;
  for (const int i : held.least_known) {
    const auto at = static_cast<std::size_t>(i);
    names += (names.empty() ? "" : ", ") + std::string(result.camera.parameterNames()[at]) + " (" +
             numberText("%.3g", held.free_params[at]) + " without a prior)";
  }
  findings.push_back({.severity = Severity::kWarning,
                      .id = "ill_conditioned",
                      .message = "these views do not determine the lens: " + names +
                                 " may be exchanged for one another or hang on no corner at all. They are "
                                 "held by the assumption that "
                                 "each parameter moves the outermost corners by about " +
                                 numberText("%g", held.width) + " times half the image's diagonal at most",
                      .next_step = "use a smaller model, or add views that reach the image's corners"});
}

void judgeDomain(const CalibrationResult& result, std::vector<Finding>& findings) {
  if (result.domain.full_image) return;
  std::string where;
  if (const auto& pixel = result.domain.pixel_without_ray) {
    where =
        ": pixel (" + numberText("%.1f", pixel->x()) + ", " + numberText("%.1f", pixel->y()) + ") has no ray";
  }
  if (!result.domain.cone.is_limited_by_fold) {
    // A wide lens leaves the image's corners dark: no ray of its ends there.
    findings.push_back(
        {.severity = Severity::kWarning,
         .id = "pixels_without_ray",
         .message = "the model ends " + numberText("%.0f", degrees(result.domain.cone.max_angle_rad)) +
                    " degrees from the axis, inside the image" + where,
         .next_step = "look whether the lens leaves these pixels dark; if it does not, use another model"});
    return;
  }
  findings.push_back(
      {.severity = Severity::kFailure,
       .id = "folds_in_image",
       .message = "the distortion folds over inside the image" + where,
       .next_step = "add views that reach the image's corners, or use a model that suits the lens"});
}

void judgeFit(const CalibrationResult& result, std::vector<Finding>& findings) {
  if (result.solver.termination != Termination::kConverged) {
    findings.push_back({.severity = Severity::kFailure,
                        .id = "not_converged",
                        .message = "the solver stopped before the optimum: " + result.solver.reason,
                        .next_step = "look for wrong views; the worst ones are listed"});
  }
  for (const int i : result.solver.at_limit) {
    findings.push_back({.severity = Severity::kWarning,
                        .id = "parameter_at_limit",
                        .message = std::string(result.camera.parameterNames()[static_cast<std::size_t>(i)]) +
                                   " has come to the end of its range, " +
                                   numberText("%g", result.camera.parameters()[static_cast<std::size_t>(i)]) +
                                   ": the model would have to bend farther than it can",
                        .next_step = "use a model that suits the lens"});
  }
  if (!result.is_settled) {
    findings.push_back(
        {.severity = Severity::kFailure,
         .id = "not_settled",
         .message =
             "each fit changes which corners look like outliers: there is no stable answer to these views",
         .next_step = "look for wrong views; the worst ones are listed"});
  }
  const double diagonal = std::hypot(result.image_size.width, result.image_size.height);
  // Weighted: corners that say themselves that they are poor are no misfit.
  const double share = result.weighted_rms_px / diagonal;
  if (!(share <= kMisfitWarn)) {
    findings.push_back(
        {.severity = share <= kMisfitNo ? Severity::kWarning : Severity::kFailure,
         .id = "misfit",
         .message = "an RMS of " + numberText("%.3g", result.weighted_rms_px) +
                    " px is more than corners' noise: the lens does not follow the model, the board is not "
                    "flat, or images are blurred",
         .next_step = "try another model; check that the board is flat and rigid; look at the worst views"});
  }
  if (result.better_model) {
    findings.push_back(
        {.severity = Severity::kFailure,
         .id = "model_too_lean",
         .message = result.better_model->id + " explains the same corners with an RMS of " +
                    numberText("%.3g", result.better_model->rms_px) + " px instead of " +
                    numberText("%.3g", result.better_model->lean_rms_px) +
                    " px: the lens has distortion that this model lacks, and its other parameters "
                    "are bent to make up for it",
         .next_step = "use --model " + result.better_model->id});
  }
  const double smoothness = result.smoothness();
  if (smoothness > kSmoothWarn && result.weighted_rms_px > kSmallRmsPx) {
    findings.push_back(
        {.severity = Severity::kWarning,
         .id = "systematic_errors",
         .message =
             "the errors are " + numberText("%.1f", smoothness) +
             " times what neighbouring corners differ by, so they vary smoothly and are not noise alone: the "
             "stated sigmas are too small",
         .next_step =
             "check that the board is flat and the images are sharp; a richer model may suit the lens"});
  }
  if (result.shape.bend_share > kBentShare) {
    findings.push_back({.severity = Severity::kWarning,
                        .id = "bent_board",
                        .message = "the board's middle stands out by " +
                                   numberText("%.2g", 100 * result.shape.bend_share) +
                                   " % of its size; so bent a board is no paraboloid, which is what is "
                                   "allowed for",
                        .next_step = "mount the board on something flat and rigid, and photograph it again"});
  }
  if (!result.shape.is_determined && result.shape.is_requested) {
    findings.push_back(
        {.severity = Severity::kWarning,
         .id = "bend_unknown",
         .message = "these views do not tell whether the board is bent, so it was taken as flat",
         .next_step = "take more views, tilted both ways, of a board with three or more "
                      "corners a side"});
  }
  if (result.num_corners_outside > 0) {
    findings.push_back({.severity = Severity::kFailure,
                        .id = "corners_outside_domain",
                        .message = std::to_string(result.num_corners_outside) +
                                   " corners lie beyond the angle at which the distortion folds over",
                        .next_step = "use a model that suits the lens"});
  }
  const auto params = result.camera.parameters();
  const bool is_centred = params[2] > 0 && params[2] < result.image_size.width && params[3] > 0 &&
                          params[3] < result.image_size.height;
  if (!is_centred) {
    findings.push_back(
        {.severity = Severity::kFailure,
         .id = "principal_point_outside",
         .message = "the principal point (" + numberText("%.0f", params[2]) + ", " +
                    numberText("%.0f", params[3]) + ") lies outside the image",
         .next_step = "check that the images are neither cropped nor mixed from several cameras"});
  }
  const double aspect = params[0] / params[1];
  constexpr double kOddAspect = 1.03;
  if (std::max(aspect, 1 / aspect) > kOddAspect) {
    findings.push_back(
        {.severity = Severity::kWarning,
         .id = "odd_aspect",
         .message = "fx / fy is " + numberText("%.3f", aspect) + "; pixels of almost all sensors are square",
         .next_step = "check whether the images were stretched and whether the board's squares are square"});
  }
}

}  // namespace

double CalibrationResult::parameterStd(int i) const {
  if (!covariance) return std::numeric_limits<double>::quiet_NaN();
  return std::sqrt((*covariance)(i, i));
}

double CalibrationResult::outlierShare() const {
  const auto num_out = static_cast<double>(outliers.size());
  return num_out / (num_out + num_corners);
}

double CalibrationResult::smoothness() const {
  return weighted_rms_px / std::sqrt(2.0) / local_sigma_px;
}

bool CalibrationResult::isTrustworthy() const {
  return std::none_of(findings.begin(), findings.end(),
                      [](const Finding& f) { return f.severity == Severity::kFailure; });
}

std::vector<Finding> judge(const CalibrationResult& result) {
  std::vector<Finding> findings;
  judgeFit(result, findings);
  judgeObservability(result, findings);
  judgeConditioning(result, findings);
  judgeDomain(result, findings);
  judgeData(result, findings);
  std::stable_partition(findings.begin(), findings.end(),
                        [](const Finding& f) { return f.severity == Severity::kFailure; });
  return findings;
}

}  // namespace alidade
