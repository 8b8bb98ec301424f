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
#include "alidade/calibrate/judge/diagnoses.h"
#include "alidade/camera/lens_shapes.h"
#include "alidade/core/mapped.h"
#include "alidade/core/number_text.h"

namespace alidade::detail {
namespace {

double degrees(double radians) {
  return radians * 180 / std::numbers::pi;
}

void cornersOutsideDomain(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  const std::size_t num_outside = numCornersOutside(of.fit, of.camera);
  if (num_outside > 0) {
    diagnoses.push_back({.id = "corners_outside_domain",
                         .cause = "corners lie outside the domain of the lens model",
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
        {.id = "principal_point_outside",
         .cause = "the principal point lies outside the image",
         .evidence = "(" + numberText("%.0f", params[2]) + ", " + numberText("%.0f", params[3]) + ")",
         .next_step = "check that the images are uncropped and from a single camera",
         .is_undecided = true});
  }
}

void oddAspect(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  constexpr double kOddAspect = 1.03;
  const auto params = of.camera.parameters();
  const double aspect = params[0] / params[1];
  if (std::max(aspect, 1 / aspect) <= kOddAspect) return;
  // Some sensors have such pixels, so this is not a failure.
  addByEffect(
      of,
      {.id = "odd_aspect",
       .cause = "pixels are not square",
       .evidence = "fx / fy = " + numberText("%.3f", aspect),
       .next_step = "check that the images were not stretched and that the board's squares are square"},
      0.5 * std::abs(aspect - 1) * halfDiagonal(of), diagnoses, Severity::kWarning);
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
  std::sort(tilts.begin(), tilts.end());
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

void undetermined(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  const double focal_std = relativeFocalStd(of);
  // With an unknown focal length, noise can tilt single views; the median is robust against this.
  const std::vector<double> tilts = tiltsDeg(of.fit);
  const double tilt = tilts[tilts.size() / 2];
  const bool is_unknown = !(focal_std < kFocalUnknown);
  const bool is_parallel = tilts[tilts.size() - 2] < kSmallTiltDeg;
  if ((is_unknown && tilt < kSmallTiltDeg) || is_parallel) {
    // A small standard deviation does not help: it assumes that the lens follows the model exactly.
    diagnoses.push_back(
        {.id = "fronto_parallel",
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
    diagnoses.push_back(
        {.id = "unobservable",
         .cause = "the views do not determine all parameters",
         .evidence = "condition number " + numberText("%.1g", of.uncertainty.scaled_condition),
         .next_step = "add views with other tilts, distances and image positions, or use a smaller model"});
  } else if (is_unknown) {
    diagnoses.push_back(
        {.id = "focal_uncertain",
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

void inaccurate(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  if (!of.uncertainty.accuracy) return;
  const Accuracy& accuracy = *of.uncertainty.accuracy;
  if (!isInaccurate(accuracy, of.tolerance_px)) return;
  const double limit = kHopelessFactor * of.tolerance_px;
  const double share = accuracy.coveredShareWithin(limit);
  diagnoses.push_back({.id = "inaccurate",
                       .cause = "the camera is inaccurate even where boards were seen",
                       .evidence = "only " + percentText(share) + " of that region is known to within " +
                                   numberText("%.3g", limit) + " px",
                       .next_step = "take 15 to 30 sharp views, tilted by 20 to 50 degrees",
                       .effect_px = accuracy.covered_px});
}

// Reports a lens that no prior could constrain without contradicting the corners.
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
  diagnoses.push_back({.id = "ill_conditioned",
                       .cause = "lens parameters compensate for each other and have unrealistic values",
                       .evidence = names,
                       .next_step = "use a smaller model, or add views that reach the image corners"});
}

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
  diagnoses.push_back({.id = "ill_conditioned",
                       .cause = "the views do not determine the lens; a weak prior regularises it",
                       .evidence = changes,
                       .next_step = "use a smaller model, or add views that reach the image corners"});
}

std::string cameraText(const AnyCamera& camera, std::span<const double> params, double rms_px) {
  std::string text = "fx " + numberText("%.4g", params[0]) + " px";
  const auto names = camera.parameterNames();
  for (std::size_t i = 4; i < params.size(); ++i)
    text += ", " + std::string(names[i]) + " " + numberText("%.3g", params[i]);
  return text + " (RMS " + numberText("%.5g", rms_px) + " px)";
}

void ambiguousOptimum(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  if (of.uncertainty.other_optima.empty()) return;
  const OtherOptimum& other = of.uncertainty.other_optima.front();
  const double effect_px = effectOfCamera(of, AnyCamera::make(onlyCamera(of.fit).model, other.params));
  addByEffect(of,
              {.id = "ambiguous_optimum",
               .cause = "two cameras explain the views equally well",
               .evidence = cameraText(of.camera, of.camera.parameters(), weightedRms(of.fit)) + " and " +
                           cameraText(of.camera, other.params, other.rms_px),
               .next_step = "add closer, steeper views that reach the image border, or use a smaller model"},
              effect_px, diagnoses);
}

std::string domainText(const DomainCertificate& domain) {
  std::string text = numberText("%.0f", degrees(domain.cone.max_angle_rad)) + " degrees from the axis";
  if (const auto& pixel = domain.pixel_without_ray) {
    text +=
        "; pixel (" + numberText("%.1f", pixel->x()) + ", " + numberText("%.1f", pixel->y()) + ") has no ray";
  }
  return text;
}

void foldsInImage(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  if (of.domain.full_image || !foldsInsideImage(of.domain)) return;
  diagnoses.push_back(
      {.id = "folds_in_image",
       .cause = "the distortion folds over inside the image",
       .evidence = domainText(of.domain),
       .next_step = "add views that reach the image corners, or use a model that suits the lens",
       .is_undecided = true});
}

// Wide lenses leave the image corners dark.
void pixelsWithoutRay(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  if (of.domain.full_image || foldsInsideImage(of.domain)) return;
  diagnoses.push_back({.id = "pixels_without_ray",
                       .cause = "some pixels have no ray",
                       .evidence = domainText(of.domain),
                       .next_step = "check that the lens leaves these pixels dark"});
}

void poorCoverage(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  constexpr double kMostOfImage = 0.9;
  if (!of.uncertainty.accuracy) return;
  const Accuracy& accuracy = *of.uncertainty.accuracy;
  const double share = accuracy.shareWithin(of.tolerance_px);
  // Coverage is worth reporting only if the accuracy is known.
  if (share >= kMostOfImage || isInaccurate(accuracy, of.tolerance_px)) return;
  diagnoses.push_back(
      {.id = "poor_coverage",
       .cause = "only " + percentText(share) +
                (of.domain.full_image ? " of the image is" : " of the pixels with a ray are") +
                " known to within " + numberText("%.3g", of.tolerance_px) + " px",
       .next_step = "take the suggested view",
       .effect_px = accuracy.worst_px});
}

}  // namespace

void diagnoseLens(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  for (const auto& diagnose :
       {cornersOutsideDomain, principalPointOutside, oddAspect, undetermined, inaccurate, illConditioned,
        ambiguousOptimum, foldsInImage, pixelsWithoutRay, poorCoverage})
    diagnose(of, diagnoses);
}

}  // namespace alidade::detail
