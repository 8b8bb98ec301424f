// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <iterator>
#include <limits>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "alidade/calibrate/judge/judge.h"
#include "alidade/core/number_text.h"
#include "alidade/target/board_turns.h"

namespace alidade::detail {
namespace {

constexpr double kTwoSided95 = 1.96;

std::string percent(double share) {
  return numberText("%.2g", 100 * share) + " %";
}

// Name of a view's image, with its board if there are several.
std::string nameOf(const Fit& fit, const FitView& view) {
  return view.image + boardSuffix(fit, view.board);
}

// The stated accuracy in the area that boards covered, px; NaN if it is unknown.
double coveredError(const Evidence& of) {
  const auto& accuracy = of.uncertainty.accuracy;
  return accuracy ? accuracy->covered_px : std::numeric_limits<double>::quiet_NaN();
}

// With few views nothing contradicts a mistake, so all results may be wrong.
void fewViews(Evidence& of) {
  constexpr std::size_t kFewViews = 8;
  const std::size_t num_places = of.uncertainty.num_places;
  if (num_places >= kFewViews) return;
  of.add({.id = "few_views",
          .cause = "too few board positions to reveal a mistake",
          .evidence = std::to_string(num_places) + " in " + counted(of.fit.views.size(), "view"),
          .next_step = "use at least 8, ideally 15 to 30, with the board in different places"},
         coveredError(of), Severity::kWarning);
}

// The errors of views in succession, if they are alike, do not cancel out, and no corner noise shows them.
void correlatedViews(Evidence& of) {
  if (!of.isSeries()) return;
  const auto num_views = static_cast<double>(of.uncertainty.num_places);
  of.add({.id = "correlated_views",
          .cause = "successive views have similar errors, as frames of a video do",
          .evidence = counted(of.fit.views.size(), "view") + " say as much as " +
                      numberText("%.2g", std::max(1.0, num_views / of.uncertainty.by_views->serial_factor)),
          .next_step = kBetterSeries},
         coveredError(of), Severity::kWarning);
}

void outliers(Evidence& of) {
  constexpr double kMany = 0.1;      // more than any good board lost in real photographs
  constexpr double kTooMany = 0.25;  // the remaining corners may fit only by coincidence
  if (of.dropped.outliers.empty()) return;
  const double share = of.dropped.outlierShare(of.fit);
  of.add({.id = "outliers",
          .severity = share > kTooMany ? Severity::kFailure
                      : share > kMany  ? Severity::kWarning
                                       : Severity::kNote,
          .cause = "corners were left out as outliers",
          .evidence = counted(of.dropped.outliers.size(), "corner") + " (" + percent(share) + ")",
          .next_step = "check the images that --verbose lists"});
}

void viewsLeftOut(Evidence& of) {
  for (const ExcludedView& view : of.dropped.views) {
    of.add({.id = "view_left_out",
            .cause = view.image + boardSuffix(of.fit, view.board),
            .evidence = view.reason,
            .next_step = "check the image; remove it, or correct its corners"});
  }
}

void viewsDisagree(Evidence& of) {
  const std::size_t num_given = of.fit.views.size() + of.dropped.views.size();
  const std::size_t num_misfits = of.dropped.numMisfits();
  if (num_misfits == 0 || 2 * num_misfits < num_given) return;
  of.add(
      {.id = "views_disagree",
       .cause = "the views contradict each other",
       .evidence = std::to_string(num_misfits) + " of " + counted(num_given, "view") +
                   " do not fit the camera that the others agree on",
       .next_step =
           "check the board's size, and that all images are from one camera with unchanged zoom and focus"});
}

void twoCamerasMixed(Evidence& of) {
  if (!of.uncertainty.two_cameras) return;
  const auto& [minority, step] = *of.uncertainty.two_cameras;
  of.add({.id = "two_cameras",
          .cause = "the views fall into two groups: two cameras, or two settings of zoom or focus",
          .evidence = std::to_string(minority.size()) + " of " + counted(of.fit.views.size(), "view") +
                      ", including " + of.fit.views[minority.front()].image + " and " +
                      of.fit.views[minority.back()].image + ", fit another camera",
          .next_step = "calibrate each camera and setting separately"},
         effectOfStep(of, step));
  Diagnosis& added = of.diagnoses.back();
  // One camera cannot be the mean of two.
  if (added.severity == Severity::kWarning) added.severity = Severity::kFailure;
}

void repeatedViews(Evidence& of) {
  if (of.dropped.repeated.empty()) return;
  const RepeatedView& first = of.dropped.repeated.front();
  const std::size_t count = of.dropped.repeated.size();
  of.add({.id = "repeated_views",
          .cause = "views of the same board position were averaged and count as one",
          .evidence = counted(count, "view") + (count == 1 ? ", " : ", for example ") + first.image +
                      boardSuffix(of.fit, first.board) + " (same as " + first.same_as + ")",
          .next_step = "move the board or the camera between photographs"});
}

// Reports a view that fits only because it biased the camera. Without noise there is nothing to compare with.
void influentialViews(Evidence& of) {
  constexpr double kSurprise = 5.1;  // standard deviations; of 400 clean sets no view exceeded 4
  constexpr double kMove = 1;        // standard deviations
  const std::vector<ViewInfluence>& influences = of.uncertainty.influences;
  std::vector<std::size_t> order(influences.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, std::ranges::greater(),
                           [&](std::size_t v) { return influences[v].surprise_sigmas; });
  for (const std::size_t v : order) {
    const auto [move_sigmas, surprise_sigmas] = influences[v];
    if (!(surprise_sigmas > kSurprise) || !(move_sigmas > kMove)) continue;
    of.add({.id = "influential_view",
            .cause = nameOf(of.fit, of.fit.views[v]) + " contradicts the other views",
            .evidence = numberText("%.0f", surprise_sigmas) + " standard deviations",
            // A sharp one may show what the others do not.
            .next_step = "if it shows motion or a bent board, leave it out, else take more views like it"},
           // Upper bound: no projection moves by more than this in its own standard deviations.
           move_sigmas * coveredError(of) / kTwoSided95);
  }
}

// From behind, a flat board looks like a mirrored one, and nothing else does.
void mirroredViews(Evidence& of) {
  std::vector<std::string> mirrored;
  for (const FitView& view : of.fit.views) {
    if (!seesPrintedSide(cameraFromBoard(of.fit, view))) mirrored.push_back(nameOf(of.fit, view));
  }
  if (mirrored.empty()) return;
  if (mirrored.size() < of.fit.views.size()) {
    constexpr std::size_t kMost = 5;
    const std::size_t num_more = mirrored.size() - std::min(kMost, mirrored.size());
    mirrored.resize(mirrored.size() - num_more);
    of.add(
        {.id = "mirrored_view",
         .cause = join(mirrored, ", ") + (num_more > 0 ? " and " + std::to_string(num_more) + " more" : ""),
         .evidence = "the board is seen from behind, or its corners are numbered as in a mirror image"});
    return;
  }
  of.add({.id = "mirrored_view",
          .severity = Severity::kWarning,
          .cause = "all views are mirrored",
          .evidence = "the images are flipped, or show the back of a board that is printed through",
          .next_step = "say which: --mirrored image if a camera in mirror mode took them, --mirrored back if "
                       "they show the back"});
}

// The significant common errors, by cause: at most one per board, or one for all views.
std::vector<CommonError> significantErrors(const Evidence& of) {
  std::vector<CommonError> errors;
  std::ranges::copy_if(of.uncertainty.common_errors, std::back_inserter(errors),
                       [](const CommonError& error) {
                         return error.isSignificant() && error.cause != CommonCause::kGap;  // see boardGap()
                       });
  std::ranges::stable_sort(errors, {}, &CommonError::cause);
  return errors;
}

double effectOf(const Evidence& of, const CommonError& error) {
  // A wrong ratio of fx and fy: each is off by half of it.
  if (error.cause == CommonCause::kStretch && of.fit.boards[error.board].isUneven()) return 0;  // estimated
  if (error.cause == CommonCause::kStretch) return 0.5 * std::abs(error.value) * halfDiagonal(of);
  return effectOfStep(of, error.params_step);
}

Diagnosis diagnosisOf(const Evidence& of, const CommonError& error) {
  const double size = std::abs(error.value);
  const std::string of_board = boardSuffix(of.fit, error.board);
  switch (error.cause) {
    case CommonCause::kStretch:
      return {.id = "board_not_square",
              .cause = "the board's squares are not square" + of_board,
              .evidence = "width / height = " + numberText("%.4f", 1 + error.value) + " +- " +
                          numberText("%.4f", error.sigma),
              .next_step = "measure many squares in both directions; reprint if they are not square"};
    case CommonCause::kGradingX:
    case CommonCause::kGradingY:
      return {.id = "board_graded",
              .cause = std::string("the board's squares grow along its ") +
                       (error.cause == CommonCause::kGradingX ? "rows" : "columns") + of_board,
              .evidence = "by " + percent(4 * size) + " from edge to edge",
              .next_step = "measure squares at both ends; reprint if they differ"};
    case CommonCause::kTwist: {
      const double height_m = size * of.fit.boards[error.board].target.middle().x();
      return {.id = "board_twisted",
              .cause = "the board is twisted" + of_board,
              .evidence = "its corners are " + numberText("%.2g", 1e3 * height_m) + " mm out of its plane",
              .next_step = "mount the board on something flat and rigid, and photograph it again"};
    }
    case CommonCause::kFocus:
      return {.id = "focus_breathes",
              .cause = "the focal length depends on the distance to the board, as with autofocus",
              .evidence = "it changes by " + percent(size / of.uncertainty.board_distance_m) +
                          " from the boards' distance to distant points",
              .next_step = "lock the focus; if it is locked, use a larger board farther away"};
    case CommonCause::kOutward:
      return {.id = "corners_biased",
              .cause = std::string("corners at the edges of the board appear too ") +
                       (error.value > 0 ? "far out" : "far in"),
              .evidence = "by " + numberText("%.2g", size) + " px",
              .next_step = "light the board evenly, do not overexpose, and leave a wide margin"};
    case CommonCause::kHeld: {
      const auto i = static_cast<std::size_t>(error.parameter);
      const double held = of.camera.parameters()[i];
      return {
          .id = "held_value",
          .cause = std::string(of.camera.parameterNames()[i]) + " is held at " + numberText("%.6g", held) +
                   ", which the images contradict",
          .evidence = "they give " + numberText("%.6g", held + error.value) + " +- " +
                      numberText("%.2g", error.sigma),
          .next_step = "correct the value with --init, or do not hold it (--to holds what its format lacks)"};
    }
    case CommonCause::kHeldFocal: {
      const double fx = of.camera.parameters()[0];
      return {.id = "held_value",
              .cause = "fx is held at " + numberText("%.6g", fx) + " and fy at " +
                       numberText("%.6g", of.camera.parameters()[1]) + ", which the images contradict",
              .evidence = "they give fx " + numberText("%.6g", fx * (1 + error.value)) + " +- " +
                          numberText("%.2g", fx * error.sigma) + ", and fy in proportion",
              .next_step = "correct the values with --init, or do not hold them"};
    }
    case CommonCause::kGap:
    case CommonCause::kPupil:
      break;
  }
  return {
      .id = "centre_moves",
      .cause = "the rays do not meet at one point, as behind glass or with a wide lens close to the board",
      .evidence = "the point moves along the axis by " + numberText("%.2g", 1e3 * size) + " mm at 57 degrees",
      .next_step = "photograph a larger board from farther away, without glass in front of the lens"};
}

// The common error with the largest effect is reported at full severity if it is certain: of many cameras,
// some exceed three standard deviations by chance. The others, which may disappear with it, are notes.
void commonErrors(Evidence& of) {
  constexpr double kCertain = 4.5;  // standard deviations
  const std::vector<CommonError> significant = significantErrors(of);
  for (const CommonError& error : significant) {
    const double effect_px = effectOf(of, error);
    const bool is_largest = std::ranges::none_of(
        significant, [&](const CommonError& other) { return effectOf(of, other) > effect_px; });
    const Severity worst = error.sigmas() > kCertain ? Severity::kFailure : Severity::kWarning;
    of.add(diagnosisOf(of, error), effect_px, is_largest ? worst : Severity::kNote);
    // The step to a camera without the error could not be computed.
    if (std::isnan(effect_px) && of.uncertainty.accuracy) of.diagnoses.back().severity = Severity::kWarning;
  }
}

// True if the focal length varies between images. It explains about half of the variation if images are
// sheared at random, and all if focal lengths vary.
bool isFocalChange(const ViewVariations& variations) {
  constexpr double kFocalShare = 0.8;
  return variations.focal_share > kFocalShare;
}

void focalChanged(Evidence& of) {
  constexpr double kSigmas = 5;      // of F's random deviation
  constexpr double kStepSigmas = 4;  // the surest of up to 32 steps
  const ViewVariations& variations = of.uncertainty.variations;
  const double spread = variations.focal_spread;
  // Errors shared by neighbouring corners, due to imperfect boards and lenses, raise F. On good photographs F
  // reaches 7, or 3.6 times `scale`; as its share shows, the focal length is not the cause.
  const double scale = of.uncertainty.smoothness * of.uncertainty.smoothness;
  const double limit = 1 + kSigmas * std::sqrt(2.0 / static_cast<double>(of.uncertainty.num_places));
  // An effect of the distance looks like focal lengths that vary with it.
  const bool is_by_distance = std::ranges::any_of(significantErrors(of), [&](const CommonError& error) {
    return (error.cause == CommonCause::kPupil || error.cause == CommonCause::kFocus) &&
           severityOf(effectOf(of, error), of.tolerance_px) >= Severity::kWarning;
  });
  if (of.uncertainty.two_cameras || is_by_distance) return;
  Diagnosis diagnosis{
      .id = "focal_changed",
      .cause = "the focal length differs between views: zoom, focus, or several cameras",
      .next_step = "fix zoom and focus (no autofocus), and calibrate each camera and setting separately"};
  if (isFocalChange(variations) && variations.focal_f > limit * scale) {
    diagnosis.evidence = "standard deviation " + percent(spread);
    of.add(std::move(diagnosis), kTwoSided95 * spread * halfDiagonal(of));
  } else if (const auto& step = of.uncertainty.focal_step;
             step && step->sigmas > kStepSigmas * of.uncertainty.smoothness && !of.choice.better_model &&
             !(variations.rows_f > limit * scale)) {
    diagnosis.evidence = "by " + percent(std::abs(step->share)) + " from " +
                         nameOf(of.fit, of.fit.views[step->first_view]) + " on";
    of.add(std::move(diagnosis), 0.5 * std::abs(step->share) * halfDiagonal(of));
  }
}

// A board that stands still is not sheared. A shift of the principal point by optical stabilisation, or of
// the image by that of a video, looks almost the same from a plane whose pose is free.
void rollingShutter(Evidence& of) {
  constexpr double kRowsF = 20;
  constexpr double kHarmless = 1e-3;  // of the image height
  // Distortion beyond the model looks different from each pose, and squares that are not square shear each
  // view according to its roll.
  const bool is_stretched = std::ranges::any_of(significantErrors(of), [&](const CommonError& error) {
    return error.cause == CommonCause::kStretch &&
           severityOf(effectOf(of, error), of.tolerance_px) >= Severity::kWarning;
  });
  if (of.choice.better_model || of.uncertainty.hasBias() || of.uncertainty.two_cameras || is_stretched)
    return;
  const ViewVariations& variations = of.uncertainty.variations;
  const double spread = variations.rows_spread;
  if (isFocalChange(variations) || !(variations.rows_f > kRowsF) || !(spread > kHarmless)) return;
  // The error varies between views, so the camera gets the mean over all of them.
  const double effect_px = kTwoSided95 * spread * onlyCamera(of.fit).size.height /
                           std::sqrt(static_cast<double>(of.fit.views.size()));
  of.add({.id = "rolling_shutter",
          .cause = "images are sheared or shifted: motion during readout, or image stabilisation",
          .evidence = "by " + percent(spread) + " of the image height",
          .next_step = "keep camera and board still for each photograph, with stabilisation off"},
         effect_px);
}

}  // namespace

void diagnoseViews(Evidence& of) {
  for (const auto& diagnose :
       {fewViews, correlatedViews, outliers, viewsLeftOut, viewsDisagree, twoCamerasMixed, repeatedViews,
        influentialViews, mirroredViews, commonErrors, focalChanged, rollingShutter})
    diagnose(of);
}

}  // namespace alidade::detail
