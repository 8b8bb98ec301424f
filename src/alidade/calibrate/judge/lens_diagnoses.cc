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

#include "alidade/adjust/board/errors.h"
#include "alidade/adjust/board/lens_prior.h"
#include "alidade/adjust/noise/model_soundness.h"
#include "alidade/calibrate/judge/judge.h"
#include "alidade/camera/image_domain.h"
#include "alidade/camera/lens_shapes.h"
#include "alidade/core/mapped.h"
#include "alidade/core/number_text.h"
#include "alidade/core/text.h"

namespace alidade::detail {
namespace {

// True if the errors are far larger than those of corners in sharp images.
bool isMisfit(const Evidence& of) {
  constexpr double kMisfit = 0.0005;  // of the image diagonal
  // Weighted, because corners with a large stated standard deviation are no misfit.
  return weightedRms(of.fit) > kMisfit * 2 * halfDiagonal(of);
}

void notConverged(Evidence& of) {
  if (of.fit.summary.termination == Termination::kConverged) return;
  of.add({.id = "not_converged",
          .cause = "the solver stopped before it reached the optimum",
          .evidence = of.fit.summary.reason,
          .next_step = "check the images with the largest errors"});
}

void notSettled(Evidence& of) {
  if (of.choice.is_settled) return;
  of.add({.id = "not_settled",
          .cause = "the views have no stable solution",
          .evidence = "each fit changes which corners are outliers",
          .next_step = "check the images with the largest errors"});
}

void parameterAtLimit(Evidence& of) {
  for (const FitParam& param : of.fit.summary.at_limit) {
    const auto i = static_cast<std::size_t>(param.index);
    of.add({.id = "parameter_at_limit",
            .cause = std::string(of.camera.parameterNames()[i]) + " is at the limit of its range",
            .evidence = numberText("%g", of.camera.parameters()[i]),
            .next_step = "use a model that suits the lens"});
  }
}

void misfit(Evidence& of) {
  if (!isMisfit(of)) return;
  constexpr double kGross = 0.0015;  // of the image diagonal: a loose sheet, or another board
  const double rms_px = weightedRms(of.fit);
  of.add(
      {.id = "misfit",
       .cause = "the errors are far larger than corner noise: wrong board, loose sheet, wrong model, blur "
                "or motion",
       .evidence = "RMS " + numberText("%.3g", rms_px) + " px",
       .next_step = "check that the board is as stated and mounted on something rigid, and the images with "
                    "the largest errors",
       .is_cause = rms_px > kGross * 2 * halfDiagonal(of)},
      1.73 * rms_px);  // 95 % of the errors of two coordinates
}

void modelTooLean(Evidence& of) {
  if (!of.choice.better_model) return;
  const BetterModel& better = *of.choice.better_model;
  of.add({.id = "model_too_lean",
          .cause = "the lens has distortion that " + std::string(of.camera.modelId()) + " lacks",
          .evidence = better.id + " reduces the RMS from " + numberText("%.3g", better.lean_rms_px) + " to " +
                      numberText("%.3g", better.rms_px) + " px",
          .next_step = "use --model " + better.id},
         effectOfCamera(of, cameraOf(better.id, better.params)));
}

void lensDeviates(Evidence& of) {
  if (!of.uncertainty.accuracy || of.choice.better_model || isMisfit(of)) return;
  const double deviation_px = of.uncertainty.accuracy->deviation_px;
  if (deviation_px == 0) return;
  of.add({.id = "lens_deviates",
          .cause = "the lens deviates from " + std::string(of.camera.modelId()) + " by up to " +
                   numberText("%.2g", deviation_px) + " px",
          .evidence = "included in the accuracy",
          .next_step = of.choice.model ? "accept this error; no allowed model predicts corners better"
                                       : "try --model auto"},
         deviation_px);
}

// A model that was preferred, whose camera must not be used.
void modelRejected(Evidence& of) {
  if (!of.choice.model) return;
  for (const ModelCandidate& candidate : of.choice.model->candidates) {
    if (candidate.verdict != "rejected") continue;
    of.add({.id = "model_rejected",
            .cause = "the camera of " + candidate.id + ", which predicts corners as well with " +
                     std::to_string(candidate.num_params) + " parameters, must not be used",
            .evidence = candidate.reason,
            .next_step = "add views; --model " + candidate.id + " shows its diagnoses"});
  }
}

double degrees(double radians) {
  return radians * 180 / std::numbers::pi;
}

void cornersOutsideDomain(Evidence& of) {
  const std::size_t num_outside = numCornersOutside(of.fit, of.camera);
  if (num_outside > 0) {
    of.add({.id = "corners_outside_domain",
            .cause = "corners lie outside the domain of the lens model",
            .evidence = std::to_string(num_outside) + " corners",
            .next_step = "use a model that suits the lens"});
  }
}

void principalPointOutside(Evidence& of) {
  const auto params = of.camera.parameters();
  const ImageSize size = onlyCamera(of.fit).size;
  const bool is_centred = params[2] > 0 && params[2] < size.width && params[3] > 0 && params[3] < size.height;
  if (!is_centred) {
    of.add({.id = "principal_point_outside",
            .cause = "the principal point lies outside the image",
            .evidence = "(" + numberText("%.0f", params[2]) + ", " + numberText("%.0f", params[3]) + ")",
            .next_step = "check that the images are uncropped and from a single camera",
            .is_undecided = true});
  }
}

void oddAspect(Evidence& of) {
  constexpr double kOddAspect = 1.03;
  constexpr double kSigmas = 3;
  const auto params = of.camera.parameters();
  const double aspect = params[0] / params[1];
  if (std::max(aspect, 1 / aspect) <= kOddAspect) return;
  // A board that is never rolled looks the same with squares that are not square.
  const auto stretch =
      std::ranges::find(of.uncertainty.common_errors, CommonCause::kStretch, &CommonError::cause);
  const bool is_told =
      stretch != of.uncertainty.common_errors.end() && kSigmas * stretch->sigma < std::abs(aspect - 1);
  // Some sensors have such pixels, so this is not a failure.
  of.add({.id = "odd_aspect",
          .cause = is_told ? "pixels are not square" : "pixels or the board's squares are not square",
          .evidence = "fx / fy = " + numberText("%.3f", aspect),
          .next_step =
              is_told ? "check that the images were not stretched and that the board's squares are square"
                      : "turn the board by 90 degrees in some views, which tells them apart"},
         0.5 * std::abs(aspect - 1) * halfDiagonal(of), Severity::kWarning);
}

// Even a perfect fit does not make the focal length certain; assume at least this much noise, px.
constexpr double kNoiseFloorPx = 0.05;
// Standard deviation of the focal length as a share of it, above which it is unknown.
constexpr double kFocalUnknown = 0.02;
// Boards tilted by less do not separate focal length from distance.
constexpr double kSmallTiltDeg = 15.0;

// Angles between the image plane and the board, degrees, ascending.
std::vector<double> tiltsDeg(const Fit& fit) {
  std::vector<double> tilts = mapped(fit.views, [&](const FitView& view) {
    const double c = std::abs(cameraFromBoard(fit, view).rotation.matrix()(2, 2));
    return degrees(std::acos(std::min(1.0, c)));
  });
  std::ranges::sort(tilts);
  return tilts;
}

// Relative one sigma of the focal lengths on the axis: the larger of the stated one and the one by noise,
// with corners no better than the noise floor.
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

bool isFocalUnknown(const Evidence& of) {
  return !(relativeFocalStd(of) < kFocalUnknown);
}

namespace {

void undetermined(Evidence& of) {
  const double focal_std = relativeFocalStd(of);
  // With an unknown focal length, noise can tilt single views; the median is robust against this.
  const std::vector<double> tilts = tiltsDeg(of.fit);
  const double tilt = tilts[tilts.size() / 2];
  const bool is_unknown = isFocalUnknown(of);
  const bool is_parallel = tilts[tilts.size() - 2] < kSmallTiltDeg;
  if ((is_unknown && tilt < kSmallTiltDeg) || is_parallel) {
    // A small standard deviation does not help: it assumes that the lens follows the model exactly.
    of.add({.id = "fronto_parallel",
            .severity = is_unknown ? Severity::kFailure : Severity::kWarning,
            .cause =
                "the board is nearly parallel to the image, which hardly separates focal length and distance",
            .evidence = "median angle to the image plane " + numberText("%.1f", tilt) + " degrees" +
                        (std::isfinite(focal_std)
                             ? ", focal length known to " + numberText("%.2g", 100 * focal_std) + " %"
                             : ""),
            .next_step = "add views with the board tilted by 20 to 50 degrees about both of its axes",
            .is_undecided = true});
  } else if (!of.uncertainty.covariance) {
    of.add(
        {.id = "unobservable",
         .cause = "the views do not determine all parameters",
         .evidence = "condition number " + numberText("%.1g", of.uncertainty.scaled_condition),
         .next_step = "add views with other tilts, distances and image positions, or use a smaller model"});
  } else if (is_unknown) {
    of.add({.id = "focal_uncertain",
            .cause = "the focal length is not known accurately",
            .evidence = "standard deviation " + numberText("%.2g", 100 * focal_std) + " %",
            .next_step = "add views with the board tilted by 20 to 50 degrees and filling the image",
            .is_undecided = true});
  }
}

constexpr double kHopelessFactor = 5;  // of the tolerance

bool isInaccurate(const Accuracy& accuracy, double tolerance_px) {
  constexpr double kMostly = 0.5;
  return accuracy.coveredShareWithin(kHopelessFactor * tolerance_px) < 1 - kMostly;
}

void inaccurate(Evidence& of) {
  if (!of.uncertainty.accuracy) return;
  const Accuracy& accuracy = *of.uncertainty.accuracy;
  if (!isInaccurate(accuracy, of.tolerance_px)) return;
  const double limit = kHopelessFactor * of.tolerance_px;
  const double share = accuracy.coveredShareWithin(limit);
  of.add(
      {.id = "inaccurate",
       .cause = "the camera is inaccurate even where boards were seen",
       .evidence = "only " + percentText(share) + " of that region is known to within " +
                   numberText("%.3g", limit) + " px" +
                   (of.isSeries() ? "; successive views have similar errors" : ""),
       .next_step = of.isSeries() ? kBetterSeries : "take 15 to 30 sharp views, tilted by 20 to 50 degrees",
       .effect_px = accuracy.covered_px});
}

// Parameters with unrealistic values that no prior could limit without contradicting the corners.
std::vector<std::string> runaways(const Evidence& of) {
  const LensScale scale = lensScale(of.camera.modelId(), of.camera, onlyCamera(of.fit).size);
  const ParamConstraint& constraint = onlyCamera(of.fit).constraint;
  const auto params = of.camera.parameters();
  std::vector<std::string> texts;
  for (std::size_t i = 0; i < params.size(); ++i) {
    if (constraint.holds(static_cast<int>(i)) || scale.distance(params, i) <= kRunawaySizes) continue;
    texts.push_back(std::string(of.camera.parameterNames()[i]) + " " + numberText("%.3g", params[i]));
  }
  return texts;
}

void illConditioned(Evidence& of) {
  const WeakPrior& held = onlyCamera(of.fit).weak_prior;
  std::vector<std::string> texts;
  if (held.isNone()) texts = runaways(of);
  if (held.isNone() && texts.empty()) return;
  for (const int i : held.isNone() ? std::vector<int>() : held.least_known) {
    const auto at = static_cast<std::size_t>(i);
    texts.push_back(std::string(of.camera.parameterNames()[at]) + " from " +
                    numberText("%.3g", held.free_params[at]) + " to " +
                    numberText("%.3g", of.camera.parameters()[at]));
  }
  of.add({.id = "ill_conditioned",
          .cause = held.isNone() ? "lens parameters compensate for each other and have unrealistic values"
                                 : "the views do not determine the lens; a weak prior regularises it",
          .evidence = join(texts, ", "),
          .next_step = "use a smaller model, or add views that reach the image corners"});
}

std::string cameraText(const AnyCamera& camera, std::span<const double> params, double rms_px) {
  std::string text = "fx " + numberText("%.4g", params[0]) + " px";
  const auto names = camera.parameterNames();
  for (std::size_t i = 4; i < params.size(); ++i)
    text += ", " + std::string(names[i]) + " " + numberText("%.3g", params[i]);
  return text + " (RMS " + numberText("%.5g", rms_px) + " px)";
}

void ambiguousOptimum(Evidence& of) {
  if (of.uncertainty.other_optima.empty()) return;
  const OtherOptimum& other = of.uncertainty.other_optima.front();
  const double effect_px = effectOfCamera(of, cameraOf(onlyCamera(of.fit).model, other.params));
  of.add({.id = "ambiguous_optimum",
          .cause = "two cameras explain the views equally well",
          .evidence = cameraText(of.camera, of.camera.parameters(), weightedRms(of.fit)) + " and " +
                      cameraText(of.camera, other.params, other.rms_px),
          .next_step = "add closer, steeper views that reach the image border, or use a smaller model"},
         effect_px);
}

std::string domainText(const DomainCertificate& domain) {
  std::string text = numberText("%.0f", degrees(domain.cone.max_angle_rad)) + " degrees from the axis";
  if (const auto& pixel = domain.pixel_without_ray) {
    text +=
        "; pixel (" + numberText("%.1f", pixel->x()) + ", " + numberText("%.1f", pixel->y()) + ") has no ray";
  }
  return text;
}

void pupilUndetermined(Evidence& of) {
  if (!of.choice.is_pupil_undetermined) return;
  of.add({.id = "pupil_undetermined",
          .cause = "the views do not determine the lens itself, so its entrance pupil was taken as fixed"});
}

void pixelsWithoutRay(Evidence& of) {
  if (of.domain.full_image) return;
  if (foldsInsideImage(of.domain)) {
    of.add({.id = "folds_in_image",
            .cause = "the distortion folds over inside the image",
            .evidence = domainText(of.domain),
            .next_step = "add views that reach the image corners, or use a model that suits the lens",
            .is_undecided = true});
    return;
  }
  // Wide lenses leave the image corners dark.
  of.add({.id = "pixels_without_ray",
          .cause = "some pixels have no ray",
          .evidence = domainText(of.domain),
          .next_step = "check that the lens leaves these pixels dark"});
}

void poorCoverage(Evidence& of) {
  constexpr double kMostOfImage = 0.9;
  if (!of.uncertainty.accuracy) return;
  const Accuracy& accuracy = *of.uncertainty.accuracy;
  const double share = accuracy.shareWithin(of.tolerance_px);
  // Coverage is worth reporting only if the accuracy is known.
  if (share >= kMostOfImage || isInaccurate(accuracy, of.tolerance_px)) return;
  of.add({.id = "poor_coverage",
          .cause = "only " + percentText(share) +
                   (of.domain.full_image ? " of the image is" : " of the pixels with a ray are") +
                   " known to within " + numberText("%.3g", of.tolerance_px) + " px",
          .next_step = "take the suggested view",
          .effect_px = accuracy.worst_px});
}

}  // namespace

void diagnoseLens(Evidence& of) {
  for (const auto& diagnose :
       {notConverged, notSettled, parameterAtLimit, misfit, modelTooLean, lensDeviates, modelRejected,
        cornersOutsideDomain, principalPointOutside, oddAspect, undetermined, inaccurate, illConditioned,
        ambiguousOptimum, pupilUndetermined, pixelsWithoutRay, poorCoverage})
    diagnose(of);
}

}  // namespace alidade::detail
