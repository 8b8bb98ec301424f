// SPDX-License-Identifier: MIT
#include "alidade/validate/held_out/held_out_checks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "alidade/core/statistics.h"
#include "alidade/validate/held_out/misfit.h"

namespace alidade {
namespace {

// What is left of an RMS once another is taken out of it.
double beyond(double rms_px, double explained_px) {
  return std::sqrt(std::max(0.0, rms_px * rms_px - explained_px * explained_px));
}

std::string worstViewText(const HeldOutJudgement& judgement) {
  const auto worst = std::max_element(judgement.views.begin(), judgement.views.end(),
                                      [](const HeldOutView& a, const HeldOutView& b) {
                                        return !(b.rms_px <= a.rms_px) && std::isfinite(b.rms_px);
                                      });
  return fmt::format("the worst view is {} with {:.3g} px", worst->image, worst->rms_px);
}

// Whether the calibration by the images alone failed as such, and not only for want of views of the whole
// image: what they do not determine is in its covariance.
bool isFreedWrong(const Calibration& freed) {
  return std::any_of(freed.diagnoses.begin(), freed.diagnoses.end(), [](const Diagnosis& diagnosis) {
    return diagnosis.severity == Severity::kFailure && !diagnosis.is_undecided;
  });
}

Diagnosis heldOutErrorCheck(const HeldOutJudgement& judgement, double tolerance_px) {
  Diagnosis check{
      .severity = Severity::kPass,
      .id = "held_out_error",
      .cause = {},
      .evidence = fmt::format("{:.3g} px RMS over {} corners of {} of {} views", judgement.held_out_rms_px,
                              judgement.num_corners, judgement.views.size(), judgement.num_views_given),
      .limit = {}};
  const double noise_px = std::isfinite(judgement.noise_rms_px) ? judgement.noise_rms_px : 0.0;
  check.limit = fmt::format("{:.3g} px: noise of {:.3g} px and the tolerance of {} px",
                            std::hypot(noise_px, tolerance_px), noise_px, tolerance_px);
  if (judgement.num_corners == 0) {
    check.evidence = "no corner could be held out";
    if (judgement.num_unseen == 0) {
      check.severity = Severity::kWarning;
      check.cause =
          "the views have too few corners of either colour of the board to predict one from the other (four, "
          "not in a line); show more of the board";
      return check;
    }
    check.severity = Severity::kFailure;
    check.cause =
        "the camera does not see the boards of these images from any pose; are they its images, and "
        "is the board's size right?";
    return check;
  }
  if (judgement.num_unseen > 0) {
    check.severity = Severity::kFailure;
    check.cause = fmt::format("{} corners that the images show are outside of what the camera can see",
                              judgement.num_unseen);
    return check;
  }
  const double freed_px = judgement.freed && std::isfinite(judgement.freed->uncertainty.holdout.rms_px)
                              ? judgement.freed->uncertainty.holdout.rms_px
                              : noise_px;
  if (beyond(judgement.held_out_rms_px, noise_px) <= tolerance_px) {
    check.cause =
        "the camera predicts corners that had no part in their view's pose; " + worstViewText(judgement);
    return check;
  }
  // A camera is not to blame for what no camera of its model would predict better, unless that is the model.
  const bool is_camera = beyond(judgement.held_out_rms_px, freed_px) > tolerance_px;
  const bool is_model = judgement.freed && isFreedWrong(*judgement.freed);
  check.severity = is_camera || is_model || !judgement.freed ? Severity::kFailure : Severity::kWarning;
  if (check.severity == Severity::kWarning) {
    check.cause = fmt::format(
        "the images have errors beyond noise that no camera of this model explains (held out {:.3g} px with "
        "its "
        "parameters free): blur, a moving board or a rolling shutter; {}",
        freed_px, worstViewText(judgement));
    return check;
  }
  check.cause = judgement.freed ? fmt::format(
                                      "the camera does not predict corners as the images allow: with its "
                                      "parameters free the error is {:.3g} px{}; {}",
                                      freed_px, is_model ? ", which no camera of this model makes good" : "",
                                      worstViewText(judgement))
                                : "the camera does not predict corners; " + worstViewText(judgement);
  return check;
}

double sureDifference(const HeldOutJudgement& judgement) {
  return judgement.overall ? judgement.overall->sure_share * judgement.difference->p95_px : 0.0;
}

std::string differenceValue(const HeldOutJudgement& judgement) {
  return fmt::format(
      "{:.3g} px (95 %), {:.3g} px of it sure, over the {:.0f} % of the image where boards were; known to "
      "{:.2g} px",
      judgement.difference->p95_px, sureDifference(judgement), 100 * judgement.covered_share,
      judgement.significance->expected_rms_px);
}

std::string textOf(const NeededChange& change) {
  const StepEstimate& estimate = change.refined ? *change.refined : change.estimate;
  return fmt::format("{} ({:.1f} sigma)",
                     complaintOf(change.change, estimate.amount, estimate.effectiveStd()), estimate.sigmas);
}

bool isNeeded(const NeededChange& change, double tolerance_px) {
  return change.change != CameraChange::kPixelOrigin && change.estimate.isSignificant() &&
         change.p95_px > tolerance_px;
}

bool isAnyNeeded(const HeldOutJudgement& judgement, double tolerance_px) {
  return std::any_of(judgement.changes.begin(), judgement.changes.end(),
                     [&](const NeededChange& change) { return isNeeded(change, tolerance_px); });
}

// Whether the errors that a change leaves are about those that are left with all parameters free. Where what
// remains is larger than the images' own errors (in squares, so that together they are 1.4 times as long),
// the camera is not the images' one after the change either, and whoever made it would have been misled.
bool isCloseToFreed(const NeededChange& change, const HeldOutJudgement& judgement) {
  const double freed_px = std::max(judgement.freed_rms_px, std::numbers::sqrt2 * kFinestPx);
  return beyond(change.refined_rms_px, freed_px) <= freed_px;
}

// Of what the images have against the camera (the mean square of its errors less that of the freed one's),
// the share that the change by itself takes away, poses refitted. Where errors are small all through, being
// close to the freed camera says nothing, and this tells the change that is needed from one that merely
// helps.
double explainedShare(const NeededChange& change, const HeldOutJudgement& judgement) {
  const auto square = [](double x) { return x * x; };
  const double excess = square(judgement.fixed_rms_px) - square(judgement.freed_rms_px);
  return excess > 0 ? (square(judgement.fixed_rms_px) - square(change.refined_rms_px)) / excess : 0.0;
}

// The needed change that by itself explains most of what the images have against the camera. Where none does,
// something else is wrong, and a single change would be the wrong name for it.
const NeededChange* explanation(const HeldOutJudgement& judgement, double tolerance_px) {
  constexpr double kMost = 0.7;
  const NeededChange* best = nullptr;
  double best_share = kMost;
  for (const NeededChange& change : judgement.changes) {
    if (!isNeeded(change, tolerance_px) || !change.refined || !isCloseToFreed(change, judgement)) continue;
    const double share = explainedShare(change, judgement);
    if (!(share >= best_share)) continue;
    best_share = share;
    best = &change;
  }
  return best;
}

const NeededChange* find(const HeldOutJudgement& judgement, CameraChange change) {
  const auto found = std::find_if(judgement.changes.begin(), judgement.changes.end(),
                                  [&](const NeededChange& c) { return c.change == change; });
  return found == judgement.changes.end() ? nullptr : &*found;
}

// Whether the principal point is off by what it is between the two conventions of where pixels begin, and by
// nothing else: both coordinates together surest of all, and either by half a pixel as far as it is known.
const NeededChange* otherPixelOrigin(const HeldOutJudgement& judgement) {
  constexpr double kHalf = 0.5;
  constexpr double kLeast = 0.3;
  constexpr double kMost = 0.7;
  if (judgement.changes.empty()) return nullptr;
  const NeededChange& surest = judgement.changes.front();
  const NeededChange* const x = find(judgement, CameraChange::kCenterX);
  const NeededChange* const y = find(judgement, CameraChange::kCenterY);
  if (surest.change != CameraChange::kPixelOrigin || !surest.estimate.isSignificant() || x == nullptr ||
      y == nullptr)
    return nullptr;
  const double size = std::abs(surest.estimate.amount);
  const double half = std::copysign(kHalf, surest.estimate.amount);
  const auto isHalf = [&](const NeededChange& change) {
    return std::abs(change.estimate.amount - half) <= 2 * change.estimate.effectiveStd();
  };
  return size >= kLeast && size <= kMost && isHalf(*x) && isHalf(*y) ? &surest : nullptr;
}

// What is beyond chance but not beyond the tolerance, and what may be.
std::string hintText(const HeldOutJudgement& judgement, double tolerance_px) {
  for (const NeededChange& change : judgement.changes) {
    if (!change.isHint() || change.change == CameraChange::kPixelOrigin) continue;
    if (!change.refined || (judgement.freed && !isCloseToFreed(change, judgement))) continue;
    if (!change.estimate.isSignificant()) return "; a hint, but no proof: " + textOf(change);
    if (change.p95_px <= tolerance_px)
      return fmt::format("; off, but by less than the tolerance ({:.2g} px): {}", change.p95_px,
                         textOf(change));
  }
  return "";
}

// Whether the errors as the camera is exceed those with its parameters free by far: three times as long, by
// more than the tolerance, and more than what views share by chance explains (once in 1000). The covariance
// and the difference between both cameras, which may be lost where one is nonsense, are not needed for that.
bool isFarOff(const HeldOutJudgement& judgement, double tolerance_px) {
  constexpr double kByFar = 3;
  return judgement.misfit_sigmas > kNormalOneInThousand &&
         judgement.fixed_rms_px > kByFar * judgement.freed_rms_px &&
         beyond(judgement.fixed_rms_px, judgement.freed_rms_px) > tolerance_px;
}

std::string evidenceText(const HeldOutJudgement& judgement, double tolerance_px) {
  std::string text;
  // Far off, where projection is no longer nearly linear, the test of all parameters says less and less.
  if (judgement.overall && !isFarOff(judgement, tolerance_px))
    text = fmt::format("all parameters together {:.1f} sigma; ", std::max(0.0, judgement.overall->sigmas));
  text += fmt::format("RMS {:.3g} px as it is", judgement.fixed_rms_px);
  if (std::isfinite(judgement.freed_rms_px))
    text += fmt::format(", {:.3g} px with its parameters free", judgement.freed_rms_px);
  return text;
}

// Another camera than that of the images: fails, unless what the images say cannot be trusted itself.
void reject(const HeldOutJudgement& judgement, double tolerance_px, const std::string& more,
            Diagnosis& check) {
  const bool is_usable = judgement.freed && !isFreedWrong(*judgement.freed);
  check.severity = is_usable ? Severity::kFailure : Severity::kWarning;
  check.cause = is_usable ? "the images show another camera"
                          : "the images seem to show another camera, but the calibration by them alone is "
                            "not to be trusted";
  const NeededChange* const reason = explanation(judgement, tolerance_px);
  if (reason != nullptr) {
    check.cause += ": if nothing else is wrong, " + textOf(*reason);
  } else {
    check.cause += isFarOff(judgement, tolerance_px) ? ": the file's is far off, and no" : ": no";
    check.cause +=
        " single change was found to explain it; more than one number may be wrong, or the lens be another";
  }
  check.cause += "; " + evidenceText(judgement, tolerance_px);
  if (!is_usable) check.cause += "; " + more;
}

// What the images make of the difference to the camera that they give by themselves.
void judgeDifference(const HeldOutJudgement& judgement, double tolerance_px, const std::string& more,
                     Diagnosis& check) {
  const double p95_px = judgement.difference->p95_px;
  const double expected_px = judgement.significance->expected_rms_px;
  const bool is_other = judgement.overall && judgement.overall->isSignificant() && p95_px > tolerance_px;
  if (is_other || isAnyNeeded(judgement, tolerance_px) || isFarOff(judgement, tolerance_px)) {
    reject(judgement, tolerance_px, more, check);
    return;
  }
  const bool is_within = p95_px <= tolerance_px;
  if (is_within && expected_px <= tolerance_px) {
    check.severity = Severity::kPass;
    check.cause = "the images show the same camera; " + evidenceText(judgement, tolerance_px);
    return;
  }
  check.cause =
      is_within ? fmt::format("these images agree, but would not notice an error of {:.2g} px", expected_px)
                : "these images cannot tell whether it is the same camera; " +
                      evidenceText(judgement, tolerance_px);
  check.cause += hintText(judgement, tolerance_px) + "; " + more;
}

Diagnosis imagesAgreeCheck(const HeldOutJudgement& judgement, double tolerance_px) {
  Diagnosis check{
      .severity = Severity::kWarning,
      .id = "images_agree",
      .cause = {},
      .evidence = "not known",
      .limit = fmt::format("{} px", tolerance_px),
      .is_undecided = true};  // whatever warns here does so for want of evidence, with one exception
  const std::string more =
      "take more images, tilted and all over the image (see the advice of alidade calibrate)";
  if (!judgement.freed) {
    check.cause = "the images give no camera to compare with: " + judgement.freed_complaint +
                  hintText(judgement, tolerance_px);
    return check;
  }
  if (judgement.num_corners == 0 && judgement.num_unseen > 0) {
    check.severity = isFreedWrong(*judgement.freed) ? Severity::kWarning : Severity::kFailure;
    check.cause = fmt::format(
        "the images show another camera: the file's does not see their boards from any pose; RMS {:.3g} px "
        "with its parameters free",
        judgement.freed_rms_px);
    return check;
  }
  if (!judgement.difference || !judgement.significance) {
    if (isFarOff(judgement, tolerance_px)) {
      reject(judgement, tolerance_px, more, check);
      return check;
    }
    check.cause = "the images do not determine a camera to compare with" + hintText(judgement, tolerance_px) +
                  "; " + more;
    return check;
  }
  if (!isComparable(*judgement.difference)) {
    check.evidence = fmt::format("{} of {} pixels are seen by one of both cameras only",
                                 judgement.difference->num_seen_by_one, judgement.difference->pixels.size());
    if ((judgement.overall && judgement.overall->isSignificant()) || isAnyNeeded(judgement, tolerance_px) ||
        isFarOff(judgement, tolerance_px)) {
      reject(judgement, tolerance_px, more, check);
    } else {
      check.cause = "the camera by the images alone cannot be compared; " +
                    evidenceText(judgement, tolerance_px) + "; " + more;
    }
    return check;
  }
  check.evidence = differenceValue(judgement);
  judgeDifference(judgement, tolerance_px, more, check);
  const NeededChange* const origin = otherPixelOrigin(judgement);
  if (origin != nullptr && check.severity != Severity::kFailure) {
    check.severity = Severity::kWarning;
    check.is_undecided = false;
    check.cause = textOf(*origin) +
                  ": half a pixel, as if the file put the pixel's origin elsewhere than its format does; " +
                  check.cause;
  }
  return check;
}

}  // namespace

std::vector<Diagnosis> heldOutChecks(const HeldOutJudgement& judgement, double tolerance_px) {
  Diagnosis agree = imagesAgreeCheck(judgement, tolerance_px);
  agree.is_undecided = agree.is_undecided && agree.severity == Severity::kWarning;
  return {heldOutErrorCheck(judgement, tolerance_px), std::move(agree)};
}

Diagnosis againstCheck(const ComparedCamera& camera, const ComparedCamera& other, double tolerance_px) {
  const ProjectionDifference difference = projectionDifference(camera, other);
  const auto significance = significanceOf(difference, camera, other, Freed::kRotation);
  Diagnosis check{.severity = Severity::kFailure,
                  .id = "against",
                  .cause = {},
                  .evidence = fmt::format("{:.3g} px (95 %), RMS {:.3g} px, at most {:.3g} px",
                                          difference.p95_px, difference.rms_px, difference.max_px),
                  .limit = fmt::format("{} px (95 %)", tolerance_px)};
  const std::string chance =
      significance ? fmt::format("{:.1f} sigma; the covariances lead to expect {:.2g} px",
                                 std::max(0.0, significance->sigmas), significance->expected_rms_px)
                   : "neither file states how well its parameters are known";
  switch (agreementOf(difference, significance, tolerance_px)) {
    case Agreement::kWithin:
      check.severity = Severity::kPass;
      check.cause = "both cameras put what they see at the same place (" + chance + ")";
      break;
    case Agreement::kBeyond:
      check.cause = "the cameras differ (" + chance + "); alidade diff shows where";
      break;
    case Agreement::kUncertain:
      check.severity = Severity::kWarning;
      check.is_undecided = true;
      check.cause = "the cameras are known too badly to tell whether they differ (" + chance + ")";
      break;
    case Agreement::kNotComparable:
      check.cause = fmt::format("the cameras cannot be compared: {} of {} pixels are seen by both",
                                difference.num_compared, difference.pixels.size());
      break;
  }
  return check;
}

}  // namespace alidade
