// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "alidade/calibrate/judge/diagnoses.h"
#include "alidade/core/number_text.h"

namespace alidade::detail {
namespace {

constexpr double kTwoSided95 = 1.96;

std::string percent(double share) {
  return numberText("%.2g", 100 * share) + " %";
}

// The significant errors of this cause: at most one per board, or one for all views.
std::vector<CommonError> significantErrors(const Evidence& of, CommonCause cause) {
  std::vector<CommonError> errors;
  for (const CommonError& error : of.uncertainty.common_errors) {
    if (error.cause == cause && error.isSignificant()) errors.push_back(error);
  }
  return errors;
}

double effectOf(const Evidence& of, const CommonError& error) {
  // A wrong ratio of fx and fy: each is off by half of it.
  if (error.cause == CommonCause::kStretch) return 0.5 * std::abs(error.value) * halfDiagonal(of);
  return effectOfStep(of, Eigen::Map<const Eigen::VectorXd>(
                              error.params_step.data(), static_cast<Eigen::Index>(error.params_step.size())));
}

// Of several common errors, the one with the largest effect is reported at full severity. The others, which
// may disappear with it, are notes.
void addCommonError(const Evidence& of, Diagnosis diagnosis, const CommonError& error,
                    std::vector<Diagnosis>& diagnoses) {
  const double effect_px = effectOf(of, error);
  const auto& all = of.uncertainty.common_errors;
  const bool is_largest = std::none_of(all.begin(), all.end(), [&](const CommonError& other) {
    return other.isSignificant() && effectOf(of, other) > effect_px;
  });
  addByEffect(of, std::move(diagnosis), effect_px, diagnoses,
              is_largest ? Severity::kFailure : Severity::kNote);
}

void boardNotSquare(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  for (const CommonError& error : significantErrors(of, CommonCause::kStretch)) {
    addCommonError(of,
                   {.id = "board_not_square",
                    .cause = "the board's squares are not square" + boardSuffix(of.fit, error.board),
                    .evidence = "width / height = " + numberText("%.4f", 1 + error.value) + " +- " +
                                numberText("%.4f", error.sigma),
                    .next_step = "measure many squares in both directions; reprint if they are not square"},
                   error, diagnoses);
  }
}

void boardGraded(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  for (const CommonCause cause : {CommonCause::kGradingX, CommonCause::kGradingY}) {
    for (const CommonError& error : significantErrors(of, cause)) {
      addCommonError(
          of,
          {.id = "board_graded",
           .cause = std::string("the board's squares grow along its ") +
                    (cause == CommonCause::kGradingX ? "rows" : "columns") + boardSuffix(of.fit, error.board),
           .evidence = "by " + percent(4 * std::abs(error.value)) + " from edge to edge",
           .next_step = "measure squares at both ends; reprint if they differ"},
          error, diagnoses);
    }
  }
}

void boardTwisted(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  for (const CommonError& error : significantErrors(of, CommonCause::kTwist)) {
    const double height_m = std::abs(error.value) * of.fit.boards[error.board].target.middle().x();
    addCommonError(
        of,
        {.id = "board_twisted",
         .cause = "the board is twisted" + boardSuffix(of.fit, error.board),
         .evidence = "its corners are " + numberText("%.2g", 1e3 * height_m) + " mm out of its plane",
         .next_step = "mount the board on something flat and rigid, and photograph it again"},
        error, diagnoses);
  }
}

void focusBreathes(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  const auto errors = significantErrors(of, CommonCause::kFocus);
  if (errors.empty()) return;
  addCommonError(
      of,
      {.id = "focus_breathes",
       .cause = "the focal length depends on the distance to the board, as with autofocus",
       .evidence = "it changes by " + percent(std::abs(errors[0].value) / of.uncertainty.board_distance_m) +
                   " from the boards' distance to distant points",
       .next_step = "lock the focus; if it is locked, use a larger board farther away"},
      errors[0], diagnoses);
}

void cornersBiased(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  const auto errors = significantErrors(of, CommonCause::kOutward);
  if (errors.empty()) return;
  addCommonError(of,
                 {.id = "corners_biased",
                  .cause = std::string("corners at the edges of the board appear too ") +
                           (errors[0].value > 0 ? "far out" : "far in"),
                  .evidence = "by " + numberText("%.2g", std::abs(errors[0].value)) + " px",
                  .next_step = "light the board evenly, do not overexpose, and leave a wide margin"},
                 errors[0], diagnoses);
}

void centreMoves(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  const auto errors = significantErrors(of, CommonCause::kPupil);
  if (errors.empty()) return;
  addCommonError(
      of,
      {.id = "centre_moves",
       .cause = "the rays do not meet at one point, as behind glass or with a wide lens close to the board",
       .evidence = "the point moves along the axis by " +
                   numberText("%.2g", 1e3 * std::abs(errors[0].value)) + " mm at 57 degrees",
       .next_step = "photograph a larger board from farther away, without glass in front of the lens"},
      errors[0], diagnoses);
}

// True if the focal length varies between images. It explains about half of the variation if images are
// sheared at random, and all if focal lengths vary.
bool isFocalChange(const ViewVariations& variations) {
  constexpr double kFocalShare = 0.8;
  return variations.focal_share > kFocalShare;
}

void focalChanged(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  constexpr double kSigmas = 5;  // of F's random deviation
  const ViewVariations& variations = of.uncertainty.variations;
  const auto [f, spread] = variations.focal;
  // Errors shared by neighbouring corners, due to imperfect boards and lenses, raise F. On good photographs F
  // reaches 7, or 3.6 times `scale`; as its share shows, the focal length is not the cause.
  const double scale = of.uncertainty.smoothness * of.uncertainty.smoothness;
  const double limit = 1 + kSigmas * std::sqrt(2.0 / static_cast<double>(of.uncertainty.num_places));
  if (of.uncertainty.two_cameras || !isFocalChange(variations) || !(f > limit * scale)) return;
  addByEffect(
      of,
      {.id = "focal_changed",
       .cause = "the focal length differs between views: zoom, focus, or several cameras",
       .evidence = "standard deviation " + percent(spread),
       .next_step = "fix zoom and focus (no autofocus), and calibrate each camera and setting separately"},
      kTwoSided95 * spread * halfDiagonal(of), diagnoses);
}

// A board that stands still is not sheared.
void rollingShutter(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  constexpr double kRowsF = 20;
  constexpr double kHarmless = 2e-3;  // of the image height
  // Distortion beyond the model looks different from each pose, and squares that are not square shear each
  // view according to its roll.
  const bool is_stretched =
      std::ranges::any_of(significantErrors(of, CommonCause::kStretch), [&](const CommonError& stretch) {
        return severityOf(effectOf(of, stretch), of.tolerance_px) >= Severity::kWarning;
      });
  if (of.choice.better_model || of.uncertainty.hasBias() || of.uncertainty.two_cameras || is_stretched)
    return;
  const ViewVariations& variations = of.uncertainty.variations;
  const auto [f, spread] = variations.rows;
  if (isFocalChange(variations) || !(f > kRowsF) || !(spread > kHarmless)) return;
  // The error varies between views, so the camera gets the mean over all of them.
  const double effect_px = kTwoSided95 * spread * onlyCamera(of.fit).size.height /
                           std::sqrt(static_cast<double>(of.fit.views.size()));
  addByEffect(of,
              {.id = "rolling_shutter",
               .cause = "images are sheared: the camera or the board moved during readout",
               .evidence = "by " + percent(spread) + " of the image height",
               .next_step = "keep camera and board still for each photograph"},
              effect_px, diagnoses);
}

}  // namespace

void diagnoseErrorPatterns(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  for (const auto& diagnose : {boardNotSquare, boardGraded, boardTwisted, focusBreathes, cornersBiased,
                               centreMoves, focalChanged, rollingShutter})
    diagnose(of, diagnoses);
}

}  // namespace alidade::detail
