// SPDX-License-Identifier: MIT
#include "alidade/validate/held_out/held_out_images.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include <fmt/format.h>

#include "alidade/calibrate/uncertainty/print_errors.h"
#include "alidade/core/statistics.h"

namespace alidade {
namespace {

// Remainder of an RMS after subtracting a smaller one in squares.
double beyond(double rms_px, double explained_px) {
  return std::sqrt(std::max(0.0, rms_px * rms_px - explained_px * explained_px));
}

std::string worstViewText(const HeldOutJudgement& judgement) {
  const auto worst =
      std::ranges::max_element(judgement.views, [](const HeldOutView& a, const HeldOutView& b) {
        return !(b.rms_px <= a.rms_px) && std::isfinite(b.rms_px);
      });
  return fmt::format("the worst view is {} with {:.3g} px", worst->image, worst->rms_px);
}

// True if the calibration from the images alone failed for a reason other than views that miss part of the
// image: its covariance already contains all that they do not determine.
bool isFreedWrong(const Calibration& freed) {
  return std::ranges::any_of(freed.diagnoses, [](const Diagnosis& diagnosis) {
    return diagnosis.severity == Severity::kFailure && !diagnosis.is_undecided && !isOfSpec(diagnosis);
  });
}

Diagnosis heldOutErrorCheck(const HeldOutJudgement& judgement, double tolerance_px) {
  const double noise_px = std::isfinite(judgement.noise_rms_px) ? judgement.noise_rms_px : 0.0;
  Diagnosis check{
      .id = "held_out_error",
      .severity = Severity::kPass,
      .cause = {},
      .evidence = fmt::format("{:.3g} px RMS over {} corners of {} of {} views", judgement.held_out_rms_px,
                              judgement.numCorners(), judgement.views.size(), judgement.num_views_given),
      .limit = fmt::format("{:.3g} px: noise of {:.3g} px and the tolerance of {} px",
                           std::hypot(noise_px, tolerance_px), noise_px, tolerance_px)};
  const auto end = [&](Severity severity, const std::string& cause) {
    check.severity = severity;
    check.cause = cause;
    return check;
  };
  if (judgement.numCorners() == 0) {
    check.evidence = "no corner could be tested";
    return judgement.numUnseen() == 0
               ? end(Severity::kWarning,
                     "the views have too few corners of either colour of the board to predict one from the "
                     "other (four, not in a line); show more of the board")
               : end(Severity::kFailure,
                     "the camera does not see the boards of these images from any pose; were the images "
                     "taken by this camera, and is the board's size right?");
  }
  if (judgement.numUnseen() > 0) {
    return end(
        Severity::kFailure,
        fmt::format("{} corners in the images lie outside the domain of the camera", judgement.numUnseen()));
  }
  const std::string worst_view = worstViewText(judgement);
  if (beyond(judgement.held_out_rms_px, noise_px) <= tolerance_px) {
    return end(Severity::kPass,
               "the camera predicts corners that were not used for the pose of their view; " + worst_view);
  }
  if (!judgement.freed) return end(Severity::kFailure, "the camera does not predict corners; " + worst_view);
  // A camera is not to blame for errors that no camera of its model avoids, except through the model.
  const double holdout_px = judgement.freed->uncertainty.holdout.rms_px;
  const double freed_px = std::isfinite(holdout_px) ? holdout_px : noise_px;
  const bool is_model = isFreedWrong(*judgement.freed);
  const FitBoard& flexing = judgement.freed->fit.boards.front();
  if (flexing.isFlexible()) {
    const std::string bends = fmt::format(
        "the board bends differently in each view (standard deviation {:.2g} mm)", 1e3 * flexing.flex.std_m);
    constexpr double kSigmas = 2;
    if (judgement.difference && judgement.significance && judgement.significance->isSignificant() &&
        judgement.difference->p95_px > tolerance_px + kSigmas * judgement.significance->expected_rms_px) {
      return end(
          Severity::kFailure,
          fmt::format("{}; with the bends estimated, the images give another camera, {:.3g} px from this one",
                      bends, judgement.difference->p95_px));
    }
    return end(Severity::kWarning, bends + ", so corners cannot be predicted; use a rigid board");
  }
  if (!is_model && beyond(judgement.held_out_rms_px, freed_px) <= tolerance_px) {
    return end(
        Severity::kWarning,
        fmt::format("the images have errors beyond noise that no camera of this model explains ({:.3g} px "
                    "with its parameters refitted): blur, a moving board or a rolling shutter; {}",
                    freed_px, worst_view));
  }
  return end(Severity::kFailure,
             fmt::format("the camera predicts corners less accurately than the images allow: with its "
                         "parameters refitted the error is {:.3g} px{}; {}",
                         freed_px, is_model ? ", which no camera of this model corrects" : "", worst_view));
}

std::string textOf(const NeededChange& change) {
  const StepEstimate& estimate = change.refined ? *change.refined : change.estimate;
  return fmt::format("{} ({:.1f} sigma)",
                     complaintOf(change.change, estimate.amount, estimate.effectiveStd()), estimate.sigmas);
}

// The change that moves the principal point between the two conventions of where pixels begin, and nothing
// else: both coordinates together are the most certain change, and each moves by half a pixel within its
// uncertainty.
const NeededChange* otherPixelOrigin(const std::vector<NeededChange>& changes) {
  constexpr double kHalf = 0.5;
  constexpr double kLeast = 0.3;
  constexpr double kMost = 0.7;
  if (changes.empty()) return nullptr;
  const NeededChange& surest = changes.front();
  const double size = std::abs(surest.estimate.amount);
  const double half = std::copysign(kHalf, surest.estimate.amount);
  const auto isHalf = [&](CameraChangeKind coordinate) {
    return std::ranges::any_of(changes, [&](const NeededChange& c) {
      return c.change == coordinate && std::abs(c.estimate.amount - half) <= 2 * c.estimate.effectiveStd();
    });
  };
  const bool is_other = surest.change == CameraChangeKind::kPixelOrigin && surest.estimate.isSignificant() &&
                        size >= kLeast && size <= kMost && isHalf(CameraChangeKind::kCenterX) &&
                        isHalf(CameraChangeKind::kCenterY);
  return is_other ? &surest : nullptr;
}

// Part of the difference to the freed camera that is beyond chance, px.
double surePx(const HeldOutJudgement& judgement) {
  return judgement.overall ? judgement.overall->sure_share * judgement.difference->p95_px : 0.0;
}

std::string differenceText(const HeldOutJudgement& judgement) {
  return fmt::format(
      "{:.3g} px (95 %), at least {:.3g} px of it real, over the {:.0f} % of the image where boards were; "
      "known to within {:.2g} px",
      judgement.difference->p95_px, surePx(judgement), 100 * judgement.covered_share,
      judgement.significance->expected_rms_px);
}

// Compares a camera with the one calibrated from the images alone.
class ImagesAgree {
 public:
  ImagesAgree(const HeldOutJudgement& judgement, double tolerance_px)
      : judgement_(judgement), tolerance_px_(tolerance_px) {
    check_.limit = fmt::format("{} px", tolerance_px);
  }

  [[nodiscard]] Diagnosis check() {
    judge();
    check_.is_undecided = check_.is_undecided && check_.severity == Severity::kWarning;
    return check_;
  }

  // The slip that check() named, or null.
  [[nodiscard]] const Slip* slip() const { return slip_; }

 private:
  void judge() {
    if (!judgement_.freed) {
      check_.cause =
          "the images do not yield a camera to compare with: " + judgement_.freed_complaint + hintText();
      return;
    }
    if (judgement_.numCorners() == 0 && judgement_.numUnseen() > 0) {
      check_.severity = isFreedWrong(*judgement_.freed) ? Severity::kWarning : Severity::kFailure;
      check_.cause = fmt::format(
          "the images do not match the camera, which does not see their boards from any pose; RMS {:.3g} px "
          "with its parameters refitted",
          judgement_.freedRmsPx());
      if (const std::string reason = explanation(); !reason.empty()) check_.cause += "; " + reason;
      return;
    }
    if (!judgement_.difference || !judgement_.significance) {
      if (isFarOff()) return reject();
      check_.cause = "the images do not determine a camera to compare with" + hintText() + "; " + kMore;
      return;
    }
    const bool is_other = judgement_.overall && judgement_.overall->isSignificant();
    const ProjectionDifference& difference = *judgement_.difference;
    if (!isComparable(difference)) {
      check_.evidence = fmt::format("{} of {} pixels are seen by only one camera", difference.num_seen_by_one,
                                    difference.pixels.size());
      if (is_other || isAnyNeeded() || isFarOff()) return reject();
      check_.cause =
          "the camera calibrated from these images cannot be compared; " + evidenceText() + "; " + kMore;
      return;
    }
    check_.evidence = differenceText(judgement_);
    if ((is_other && difference.p95_px > tolerance_px_) || isAnyNeeded() || isFarOff()) {
      reject();
    } else {
      accept(difference.p95_px <= tolerance_px_, judgement_.significance->expected_rms_px);
    }
    const NeededChange* const origin = otherPixelOrigin(judgement_.changes);
    if (origin == nullptr || check_.severity == Severity::kFailure) return;
    check_.severity = Severity::kWarning;
    check_.is_undecided = false;
    for (const Slip& slip : judgement_.slips) {
      if (slip.id == "pixel_origin" && (slip_ == nullptr || slip.rms_px < slip_->rms_px)) slip_ = &slip;
    }
    check_.cause = (slip_ != nullptr ? slip_->text + "; " : "") + textOf(*origin) + "; " + check_.cause;
  }

  // The camera is not that of the images: fails, unless the evidence of the images is itself untrustworthy.
  void reject() {
    const bool is_usable = judgement_.freed && !isFreedWrong(*judgement_.freed);
    check_.severity = is_usable ? Severity::kFailure : Severity::kWarning;
    check_.cause = is_usable ? "the images do not match the camera"
                             : "the images do not seem to match the camera, but the calibration from these "
                               "images cannot be trusted";
    if (const std::string reason = explanation(); !reason.empty()) {
      check_.cause += ": " + reason;
    } else {
      check_.cause += isFarOff() ? ": it is far off, and no" : ": no";
      check_.cause +=
          " single change was found to explain it; more than one number may be wrong, or the lens may be a "
          "different one";
    }
    check_.cause += "; " + evidenceText();
    if (!is_usable) check_.cause += std::string("; ") + kMore;
  }

  void accept(bool is_within, double expected_px) {
    if (is_within && expected_px <= tolerance_px_) {
      check_.severity = Severity::kPass;
      check_.cause = "the images match the camera; " + evidenceText();
      return;
    }
    check_.cause =
        is_within ? fmt::format("these images match the camera, but would not reveal an error of {:.2g} px",
                                expected_px)
                  : "these images cannot show whether they match the camera; " + evidenceText();
    check_.cause += hintText() + "; " + kMore;
  }

  [[nodiscard]] bool isNeeded(const NeededChange& change) const {
    return change.change != CameraChangeKind::kPixelOrigin && change.estimate.isSignificant() &&
           change.p95_px > tolerance_px_;
  }

  [[nodiscard]] bool isAnyNeeded() const {
    return std::ranges::any_of(judgement_.changes,
                               [&](const NeededChange& change) { return isNeeded(change); });
  }

  // True if errors of this size, px, are about as small as with all parameters free. If the remainder is
  // larger than the images' own errors (in squares: together 1.4 times as long), the camera still differs
  // from that of the images after the change, and making it would mislead.
  [[nodiscard]] bool isCloseToFreed(double rms_px) const {
    const double freed_px = std::max(judgement_.freedRmsPx(), std::numbers::sqrt2 * kFinestPx);
    return beyond(rms_px, freed_px) <= freed_px;
  }

  // The slip or needed change that explains most of the evidence against the camera by itself. The measure is
  // the share that it removes, with poses refitted, of the mean square of the camera's errors less that of
  // the freed one's. If none removes most, something else is wrong, and naming a single change would be
  // false. If all errors are small, being close to the freed camera proves nothing, and the share separates
  // the needed change from one that merely helps. The Bayesian information criterion chooses among several: a
  // change always fits slightly better than a slip, because it has one more parameter.
  [[nodiscard]] std::string explanation() {
    constexpr double kMost = 0.7;
    const auto square = [](double x) { return x * x; };
    const double fixed = square(judgement_.fixed_rms_px);
    const double excess = fixed - square(judgement_.freedRmsPx());
    // As in misfitSigmas(), a view counts as two numbers, however many corners it has.
    const double count = 2.0 * static_cast<double>(judgement_.freed->fit.views.size());
    double best_score = std::numeric_limits<double>::infinity();
    const auto isBest = [&](double rms_px, int num_free) {
      // A camera that does not see all corners has no mean error to compare with.
      const double share =
          judgement_.numUnseen() > 0 ? 1.0 : (excess > 0 ? (fixed - square(rms_px)) / excess : 0.0);
      const double score = count * std::log(square(std::max(rms_px, kFinestPx))) + num_free * std::log(count);
      if (!isCloseToFreed(rms_px) || !(share >= kMost) || !(score < best_score)) return false;
      best_score = score;
      return true;
    };
    std::string best;
    for (const Slip& slip : judgement_.slips) {
      // Numbers from an untrustworthy calibration cannot correct anything.
      if (slip.num_free > 0 && isFreedWrong(*judgement_.freed)) continue;
      if (!isBest(slip.rms_px, slip.num_free)) continue;
      slip_ = &slip;
      best = slip.text;
    }
    for (const NeededChange& change : judgement_.changes) {
      if (!isNeeded(change) || !change.refined || !isBest(change.refined->rms_px, 1)) continue;
      slip_ = nullptr;
      best = textOf(change);
    }
    return best.empty() ? best : "if nothing else is wrong, " + best;
  }

  // Names a change that is beyond chance but within the tolerance, or that may be.
  [[nodiscard]] std::string hintText() const {
    for (const NeededChange& change : judgement_.changes) {
      if (!change.isHint() || change.change == CameraChangeKind::kPixelOrigin) continue;
      if (!change.refined || (judgement_.freed && !isCloseToFreed(change.refined->rms_px))) continue;
      if (!change.estimate.isSignificant()) return "; a hint, not a proof: " + textOf(change);
      if (change.p95_px <= tolerance_px_)
        return fmt::format("; off, but by less than the tolerance ({:.2g} px): {}", change.p95_px,
                           textOf(change));
    }
    return "";
  }

  // True if the errors of the unchanged camera far exceed those with its parameters free: three times as
  // long, by more than the tolerance, and by more than views share by chance (once in 1000). This needs
  // neither the covariance nor the difference between the cameras, which may be missing if one is nonsense.
  [[nodiscard]] bool isFarOff() const {
    constexpr double kByFar = 3;
    return judgement_.misfit_sigmas > kNormalOneInThousand &&
           judgement_.fixed_rms_px > kByFar * judgement_.freedRmsPx() &&
           beyond(judgement_.fixed_rms_px, judgement_.freedRmsPx()) > tolerance_px_;
  }

  [[nodiscard]] std::string evidenceText() const {
    std::string text;
    // When far off, projection is no longer nearly linear, and the test of all parameters loses power.
    if (judgement_.overall && !isFarOff())
      text = fmt::format("all parameters together {:.1f} sigma; ", std::max(0.0, judgement_.overall->sigmas));
    text += fmt::format("RMS {:.3g} px as it is", judgement_.fixed_rms_px);
    if (std::isfinite(judgement_.freedRmsPx()))
      text += fmt::format(", {:.3g} px with its parameters refitted", judgement_.freedRmsPx());
    return text;
  }

  static constexpr const char* kMore =
      "take more images, with the board tilted and all over the image (see the advice of alidade calibrate)";

  const HeldOutJudgement& judgement_;
  double tolerance_px_;
  const Slip* slip_ = nullptr;
  // All warnings here are due to missing evidence, with one exception.
  Diagnosis check_{.id = "images_agree",
                   .severity = Severity::kWarning,
                   .cause = {},
                   .evidence = "unknown",
                   .is_undecided = true};
};

}  // namespace

std::vector<Diagnosis> heldOutChecks(const HeldOutJudgement& judgement, double tolerance_px) {
  std::vector<Diagnosis> checks = {heldOutErrorCheck(judgement, tolerance_px),
                                   ImagesAgree(judgement, tolerance_px).check()};
  if (!judgement.freed) return checks;
  for (Diagnosis diagnosis : judgement.freed->diagnoses) {
    if (!isOfSpec(diagnosis)) continue;
    diagnosis.severity = Severity::kWarning;
    checks.push_back(std::move(diagnosis));
  }
  return checks;
}

const Slip* namedSlip(const HeldOutJudgement& judgement, double tolerance_px) {
  ImagesAgree agree(judgement, tolerance_px);
  static_cast<void>(agree.check());
  return agree.slip();
}

Diagnosis statedAccuracyCheck(double accuracy_px, const HeldOutJudgement& judgement) {
  const bool is_measured = judgement.freed && !isFreedWrong(*judgement.freed) && judgement.difference &&
                           judgement.significance && isComparable(*judgement.difference);
  Diagnosis check{
      .id = "stated_accuracy",
      .severity = Severity::kNote,
      .cause = fmt::format("the images cannot show whether the camera is within the stated {:.3g} px",
                           accuracy_px),
      .evidence = is_measured ? differenceText(judgement) : ""};
  if (is_measured && judgement.difference->p95_px <= accuracy_px) {
    check.severity = Severity::kPass;
    check.cause = fmt::format("the measured error agrees with the stated {:.3g} px", accuracy_px);
  } else if (is_measured && surePx(judgement) > accuracy_px) {
    check.severity = Severity::kWarning;
    check.cause = fmt::format("the measured error exceeds the stated {:.3g} px", accuracy_px);
  }
  return check;
}

Diagnosis againstCheck(const ComparedCamera& camera, const ComparedCamera& other, double tolerance_px) {
  const ProjectionDifference difference = projectionDifference(camera, other);
  const auto significance = significanceOf(difference, camera, other, Freed::kRotation);
  const Agreement agreement = agreementOf(difference, significance, tolerance_px);
  Diagnosis check{.id = "against",
                  .severity = agreement == Agreement::kWithin      ? Severity::kPass
                              : agreement == Agreement::kUncertain ? Severity::kWarning
                                                                   : Severity::kFailure,
                  .cause = fmt::format("{}: {}", answerOf(agreement),
                                       agreementText(difference, significance, tolerance_px))};
  check.is_undecided = agreement == Agreement::kUncertain;
  check.evidence = significance
                       ? fmt::format("{:.1f} sigma; the covariances predict {:.2g} px",
                                     std::max(0.0, significance->sigmas), significance->expected_rms_px)
                       : "neither file states a covariance";
  if (agreement == Agreement::kBeyond) check.next_step = "see where with alidade diff";
  return check;
}

Diagnosis ownImagesCheck(std::span<const Eigen::Vector2d> recorded, std::span<const View> views) {
  constexpr double kSamePx = 0.5;  // px; leaving out one outlier moves the mean by less
  std::vector<std::string> own;
  for (const View& view : views) {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (const Corner& corner : view.corners) sum += corner.pixel;
    const Eigen::Vector2d center = sum / static_cast<double>(view.corners.size());
    const bool is_own = std::ranges::any_of(
        recorded, [&](const Eigen::Vector2d& other) { return (center - other).norm() < kSamePx; });
    if (is_own) own.push_back(view.image);
  }
  const bool is_clean = own.empty();
  return {.id = "own_images",
          .severity = is_clean ? Severity::kPass : Severity::kWarning,
          .cause = is_clean ? "the camera was not calibrated from these images"
                            : "the camera was calibrated from these images, such as " + own.front() +
                                  ": they cannot show that it is wrong; use others",
          .evidence = fmt::format("{} of {} images", own.size(), views.size()),
          .limit = "no image whose corners are those of a calibration view"};
}

}  // namespace alidade
