// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/errors.h"
#include "alidade/adjust/lens_prior.h"
#include "alidade/adjust/model_soundness.h"
#include "alidade/calibrate/judge/diagnoses.h"
#include "alidade/camera/lens_shapes.h"
#include "alidade/core/number_text.h"

namespace alidade {
namespace {

double degrees(double radians) {
  return radians * 180 / std::numbers::pi;
}

}  // namespace

void cornersOutsideDomain(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  const std::size_t num_outside = numCornersOutside(of.fit, of.camera);
  if (num_outside > 0) {
    diagnoses.push_back({.severity = Severity::kFailure,
                         .id = "corners_outside_domain",
                         .cause = "corners lie beyond the angle at which the distortion folds over",
                         .evidence = std::to_string(num_outside) + " corners",
                         .next_step = "use a model that suits the lens"});
  }
}

void principalPointOutside(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  const auto params = of.camera.parameters();
  const ImageSize size = onlyCamera(of.fit).size;
  const bool is_centred = params[2] > 0 && params[2] < size.width && params[3] > 0 && params[3] < size.height;
  if (!is_centred) {
    diagnoses.push_back(
        {.severity = Severity::kFailure,
         .id = "principal_point_outside",
         .cause = "the principal point lies outside the image",
         .evidence = "(" + numberText("%.0f", params[2]) + ", " + numberText("%.0f", params[3]) + ")",
         .next_step = "check that the images are neither cropped nor mixed from several cameras",
         .is_undecided = true});
  }
}

void oddAspect(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  constexpr double kOddAspect = 1.03;
  const auto params = of.camera.parameters();
  const double aspect = params[0] / params[1];
  if (std::max(aspect, 1 / aspect) > kOddAspect) {
    diagnoses.push_back(
        {.severity = Severity::kWarning,
         .id = "odd_aspect",
         .cause = "pixels are not square, as those of almost all sensors are",
         .evidence = "fx / fy is " + numberText("%.3f", aspect),
         .next_step = "check whether the images were stretched and whether the board's squares are square"});
  }
}

namespace {

// Even a perfect fit does not make a focal length certain; noise is taken to be at least this, px.
constexpr double kNoiseFloorPx = 0.05;
// One sigma of the focal length as a share of it: above the first the answer is no, above the second a
// warning.
constexpr double kFocalUnknown = 0.02;
constexpr double kFocalWeak = 0.005;
// Views within this of fronto-parallel tell focal length from distance badly.
constexpr double kSmallTiltDeg = 15.0;

// Angles between the image plane and the board, degrees, ascending.
std::vector<double> tiltsDeg(const Fit& fit) {
  std::vector<double> tilts;
  for (const FitView& view : fit.views) {
    const double c = std::abs(cameraFromBoard(fit, view).rotation.matrix()(2, 2));
    tilts.push_back(degrees(std::acos(std::min(1.0, c))));
  }
  std::sort(tilts.begin(), tilts.end());
  return tilts;
}

// Relative one sigma of the focal lengths on the axis, the stated one and that by noise with corners no
// better than the noise floor, whichever is larger.
double relativeFocalStd(const Evidence& of) {
  if (!of.uncertainty.covariance) return std::numeric_limits<double>::infinity();
  const Eigen::MatrixXd J = axisFocalJacobian(of.camera);
  const Eigen::Vector2d focal = axisFocal(of.camera);
  const auto largest = [&](const Eigen::MatrixXd& covariance) {
    const Eigen::Vector2d std = (J * covariance * J.transpose()).diagonal().cwiseMax(0).cwiseSqrt();
    return std.cwiseQuotient(focal).maxCoeff();
  };
  const double inflate = std::max(1.0, kNoiseFloorPx / of.uncertainty.coordinate_sigma_px);
  return std::max(inflate * largest(*of.uncertainty.covariance), largest(of.uncertainty.statedCovariance()));
}

}  // namespace

void unobservable(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  const double focal_std = relativeFocalStd(of);
  // Where the focal length is unknown, noise feigns tilts in single views; the median keeps away from those.
  const std::vector<double> tilts = tiltsDeg(of.fit);
  const double tilt = tilts[tilts.size() / 2];
  const bool is_unknown = !(focal_std < kFocalUnknown);
  const bool is_parallel = tilts[tilts.size() - 2] < kSmallTiltDeg;
  if ((is_unknown && tilt < kSmallTiltDeg) || is_parallel) {
    // That the stated sigma is small helps little: it takes the model for the lens.
    diagnoses.push_back(
        {.severity = is_unknown ? Severity::kFailure : Severity::kWarning,
         .id = "fronto_parallel",
         .cause = "the board is nearly parallel to the image in most views, so focal length and distance "
                  "cannot be told apart",
         .evidence = "median tilt " + numberText("%.1f", tilt) + " degrees" +
                     (std::isfinite(focal_std)
                          ? ", focal length known to " + numberText("%.2g", 100 * focal_std) + " %"
                          : ""),
         .next_step = "add views with the board tilted by 20 to 50 degrees, about both of its axes",
         .is_undecided = true});
  } else if (!of.uncertainty.covariance) {
    diagnoses.push_back(
        {.severity = Severity::kFailure,
         .id = "unobservable",
         .cause = "these views leave some combination of the parameters undetermined",
         .evidence = "condition " + numberText("%.1g", of.uncertainty.scaled_condition) +
                     " of the scaled information",
         .next_step =
             "add views with other tilts, distances and places in the image, or use a smaller model"});
  } else if (is_unknown || focal_std > kFocalWeak) {
    diagnoses.push_back(
        {.severity = is_unknown ? Severity::kFailure : Severity::kWarning,
         .id = "focal_uncertain",
         .cause = "the focal length is not known well",
         .evidence = "one sigma is " + numberText("%.2g", 100 * focal_std) +
                     " % of it (corners taken as no better than 0.05 px)",
         .next_step = "add views with the board tilted by 20 to 50 degrees and filling the image",
         .is_undecided = true});
  }
}

void fewViews(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  constexpr int kFewViews = 8;
  if (of.fit.views.size() < kFewViews) {
    diagnoses.push_back({.severity = Severity::kWarning,
                         .id = "few_views",
                         .cause = "there are few views to notice a mistake by",
                         .evidence = std::to_string(of.fit.views.size()) + " in use",
                         .next_step = "use at least " + std::to_string(kFewViews) + ", better 15 to 30"});
  }
}

namespace {

// Where no prior could hold a lens together without contradicting the corners.
void runaway(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  const LensScale scale = lensScale(of.camera.modelId(), of.camera, onlyCamera(of.fit).size);
  const std::vector<int>& fixed = onlyCamera(of.fit).constraint.held;
  const auto params = of.camera.parameters();
  std::string names;
  for (std::size_t i = 0; i < params.size(); ++i) {
    if (std::find(fixed.begin(), fixed.end(), static_cast<int>(i)) != fixed.end() ||
        scale.distance(params, i) <= kRunawaySizes)
      continue;
    names += (names.empty() ? "" : ", ") + std::string(of.camera.parameterNames()[i]) + " " +
             numberText("%.3g", params[i]);
  }
  if (names.empty()) return;
  diagnoses.push_back({.severity = Severity::kWarning,
                       .id = "ill_conditioned",
                       .cause =
                           "lens parameters make up for one another and went to numbers that no lens has; "
                           "where no corner was seen the model is not to be trusted, whatever its sigmas",
                       .evidence = names,
                       .next_step = "use a smaller model, or add views that reach the image's corners"});
}

}  // namespace

void illConditioned(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  const WeakPrior& held = onlyCamera(of.fit).weak_prior;
  if (held.isNone()) {
    runaway(of, diagnoses);
    return;
  }
  std::string changes;
  for (const int i : held.least_known) {
    const auto at = static_cast<std::size_t>(i);
    changes += (changes.empty() ? "" : ", ") + std::string(of.camera.parameterNames()[at]) + " from " +
               numberText("%.3g", held.free_params[at]) + " to " +
               numberText("%.3g", of.camera.parameters()[at]);
  }
  diagnoses.push_back(
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

void modelDependent(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  // As much of the image as may be uncertain before `poor_coverage` says so.
  constexpr double kMuch = 0.1;
  if (!of.uncertainty.model_spread) return;
  const ModelSpread& spread = *of.uncertainty.model_spread;
  if (spread.share_apart <= kMuch) return;
  diagnoses.push_back(
      {.severity = Severity::kWarning,
       .id = "model_dependent",
       .cause = "in parts of the image it is the choice of the model and no corner that says where points "
                "appear, and the stated sigmas know of one model alone",
       .evidence = spread.id + " predicts corners as well as " + std::string(of.camera.modelId()) +
                   " and differs by more than " + numberText("%.0f", kApartPx) + " px in " +
                   numberText("%.0f", 100 * spread.share_apart) + " % of the image, by up to " +
                   numberText("%.2g", spread.worst_px) + " px at pixel (" +
                   numberText("%.0f", spread.worst_pixel.x()) + ", " +
                   numberText("%.0f", spread.worst_pixel.y()) + ")",
       .next_step = "add views with the board in the image's borders and corners, or do not use these"});
}

namespace {

std::string cameraText(const AnyCamera& camera, std::span<const double> params, double rms_px) {
  std::string text = "fx " + numberText("%.4g", params[0]) + " px";
  const auto names = camera.parameterNames();
  for (std::size_t i = 4; i < params.size(); ++i)
    text += ", " + std::string(names[i]) + " " + numberText("%.3g", params[i]);
  return text + " (RMS " + numberText("%.5g", rms_px) + " px)";
}

}  // namespace

void ambiguousOptimum(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  if (of.uncertainty.other_optima.empty()) return;
  const OtherOptimum& other = of.uncertainty.other_optima.front();
  const std::string apart =
      std::isfinite(other.projection_px)
          ? "their projections differ by up to " + numberText("%.2g", other.projection_px) + " px"
          : "they have no pixel in common";
  diagnoses.push_back(
      {.severity = Severity::kWarning,
       .id = "ambiguous_optimum",
       .cause = "two different cameras explain the corners equally well, so either may be the true one, and "
                "the stated sigmas know of one alone",
       .evidence = cameraText(of.camera, of.camera.parameters(), weightedRms(of.fit)) + " or " +
                   cameraText(of.camera, other.params, other.rms_px) + "; " + apart +
                   "; the costs differ by a chi square of " + numberText("%.2g", other.excess_chi2),
       .next_step = "add views that reach the image's border and corners, nearer and more tilted, or use a "
                    "model with fewer parameters"});
}

void domainEndsInImage(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  if (of.domain.full_image) return;
  std::string evidence = numberText("%.0f", degrees(of.domain.cone.max_angle_rad)) + " degrees from the axis";
  if (const auto& pixel = of.domain.pixel_without_ray) {
    evidence +=
        ", pixel (" + numberText("%.1f", pixel->x()) + ", " + numberText("%.1f", pixel->y()) + ") has no ray";
  }
  if (!foldsInsideImage(of.domain)) {
    // A wide lens leaves the image's corners dark: no ray of its ends there.
    diagnoses.push_back(
        {.severity = Severity::kWarning,
         .id = "pixels_without_ray",
         .cause = "the model ends inside the image",
         .evidence = evidence,
         .next_step = "look whether the lens leaves these pixels dark; if it does not, use another model"});
    return;
  }
  diagnoses.push_back(
      {.severity = Severity::kFailure,
       .id = "folds_in_image",
       .cause = "the distortion folds over inside the image",
       .evidence = evidence,
       .next_step = "add views that reach the image's corners, or use a model that suits the lens",
       .is_undecided = true});
}

// Corners of the image that no board reached hold what the model makes of the rest. A few are usual.
void poorCoverage(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  // A pixel known to one sigma no better than this is a guess, and this share of the image may be one.
  constexpr double kGuessPx = 1.0;
  constexpr double kGuessedShare = 0.1;
  if (!of.uncertainty.projection_far) return;
  const UncertaintyGrid& grid = *of.uncertainty.projection_far;
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
  diagnoses.push_back(
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

}  // namespace alidade
