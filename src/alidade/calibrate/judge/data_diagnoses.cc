// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "alidade/calibrate/judge/judge.h"
#include "alidade/core/number_text.h"
#include "alidade/core/text.h"

namespace alidade {
namespace {

constexpr double kTwoSided95 = 1.96;

std::string percent(double share) {
  return numberText("%.2g", 100 * share) + " %";
}

// The image of a view, and its board if there are several.
std::string nameOf(const Fit& fit, const FitView& view) {
  return view.image + boardSuffix(fit, boardIndex(fit, view));
}

}  // namespace

// Nothing contradicts a mistake in a few views, so all that is claimed of them may be wrong.
void fewViews(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  constexpr std::size_t kFewViews = 8;
  const std::size_t num_places = of.uncertainty.num_places;
  if (num_places >= kFewViews) return;
  addByEffect(of,
              {.id = "few_views",
               .cause = "too few board positions to reveal a mistake",
               .evidence = std::to_string(num_places) + " in " + counted(of.fit.views.size(), "view"),
               .next_step = "use at least 8, ideally 15 to 30, with the board in different places"},
              coveredError(of), diagnoses, Severity::kWarning);
}

void outliers(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  constexpr double kMany = 0.1;      // more than any board of real photographs lost that fitted
  constexpr double kTooMany = 0.25;  // what is left may be what happens to fit
  if (of.dropped.outliers.empty()) return;
  const double share = of.dropped.outlierShare(of.fit);
  diagnoses.push_back(
      {.severity = share > kTooMany ? Severity::kFailure
                   : share > kMany  ? Severity::kWarning
                                    : Severity::kNote,
       .id = "outliers",
       .cause = "corners were left out as outliers",
       .evidence = counted(of.dropped.outliers.size(), "corner") + " (" + percent(share) + ")",
       .next_step = "check the images that --verbose lists"});
}

void viewsLeftOut(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  for (const ExcludedView& view : of.dropped.views) {
    diagnoses.push_back({.severity = Severity::kNote,
                         .id = "view_left_out",
                         .cause = view.image + boardSuffix(of.fit, view.board),
                         .evidence = view.reason,
                         .next_step = "check the image; remove it, or correct its corners"});
  }
}

void viewsDisagree(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  const std::size_t num_given = of.fit.views.size() + of.dropped.views.size();
  const std::size_t num_misfits = of.dropped.numMisfits();
  if (num_misfits == 0 || 2 * num_misfits < num_given) return;
  diagnoses.push_back(
      {.severity = Severity::kFailure,
       .id = "views_disagree",
       .cause = "the views contradict each other",
       .evidence = std::to_string(num_misfits) + " of " + counted(num_given, "view") +
                   " do not fit the camera that the others agree on",
       .next_step =
           "check the board's size, and that all images are from one camera with unchanged zoom and focus"});
}

void twoCamerasMixed(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  if (!of.uncertainty.two_cameras) return;
  const auto& [minority, step] = *of.uncertainty.two_cameras;
  const auto num_params = static_cast<Eigen::Index>(step.size());
  const double effect_px = effectOfStep(of, Eigen::Map<const Eigen::VectorXd>(step.data(), num_params));
  addByEffect(of,
              {.id = "two_cameras",
               .cause = "the views fall into two groups: two cameras, or two settings of zoom or focus",
               .evidence = std::to_string(minority.size()) + " of " + counted(of.fit.views.size(), "view") +
                           ", including " + of.fit.views[minority.front()].image + " and " +
                           of.fit.views[minority.back()].image + ", fit another camera",
               .next_step = "calibrate each camera and setting separately"},
              effect_px, diagnoses);
  Diagnosis& added = diagnoses.back();
  // No camera lies between two others.
  if (added.severity == Severity::kWarning) added.severity = Severity::kFailure;
}

void repeatedViews(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  if (of.dropped.repeated.empty()) return;
  const RepeatedView& first = of.dropped.repeated.front();
  const std::size_t count = of.dropped.repeated.size();
  diagnoses.push_back({.severity = Severity::kNote,
                       .id = "repeated_views",
                       .cause = "views of the same board position were averaged and count as one",
                       .evidence = counted(count, "view") + (count == 1 ? ", " : ", for example ") +
                                   first.image + boardSuffix(of.fit, first.board) + " (same as " +
                                   first.same_as + ")",
                       .next_step = "move the board or the camera between photographs"});
}

// A view that fits only because it has biased the camera. Without noise there is nothing to compare with.
void influentialViews(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  constexpr double kSurprise = 5.1;  // standard deviations; of 400 clean sets no view exceeded 4
  constexpr double kMove = 1;        // standard deviations
  const std::vector<ViewInfluence>& influences = of.uncertainty.influences;
  for (std::size_t v = 0; v < influences.size(); ++v) {
    const auto [move_sigmas, surprise_sigmas] = influences[v];
    if (!(surprise_sigmas > kSurprise) || !(move_sigmas > kMove)) continue;
    addByEffect(of,
                {.id = "influential_view",
                 .cause = nameOf(of.fit, of.fit.views[v]),
                 .evidence = "contradicts the other views by " + numberText("%.0f", surprise_sigmas) +
                             " standard deviations",
                 .next_step = "check the image for motion, blur or a bent board, and calibrate without it"},
                // No projection moves by more of its own standard deviations.
                move_sigmas * coveredError(of) / kTwoSided95, diagnoses);
  }
}

// From behind, a flat board looks like a mirrored one, and nothing else does.
void mirroredViews(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  std::vector<std::string> mirrored;
  for (const FitView& view : of.fit.views) {
    const SE3 pose = cameraFromBoard(of.fit, view);
    if (pose.rotation.matrix().col(2).dot(pose.translation) < 0) mirrored.push_back(nameOf(of.fit, view));
  }
  if (mirrored.size() == of.fit.views.size()) mirrored = {"all views"};
  for (const std::string& which : mirrored) {
    diagnoses.push_back({.severity = Severity::kNote,
                         .id = "mirrored_view",
                         .cause = which,
                         .evidence = "the corners are numbered as in a mirror image",
                         .next_step = "check whether images were flipped; if not, only the poses are wrong"});
  }
}

namespace {

// The errors of this cause that are significant: one a board at most, or one for all views.
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

// Of several errors that all views have in common the one with the largest effect is told; the others, which
// may be gone with it, are notes.
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

}  // namespace

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

namespace {

// One camera has one focal length. Of what varies the focal length explains about a half if images are
// sheared at random, and all if focal lengths vary.
bool isFocalChange(const ViewVariations& variations) {
  constexpr double kFocalShare = 0.8;
  return variations.focal_share > kFocalShare;
}

}  // namespace

void focalChanged(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  constexpr double kSigmas = 5;  // of F's deviation by chance
  const ViewVariations& variations = of.uncertainty.variations;
  const auto [f, spread] = variations.focal;
  // Neighbouring corners that err alike, as boards and lenses that are not perfect make them, raise F. On
  // good photographs F reaches 7, in units of that 3.6: not by the focal length, as its share says.
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
  // Distortion that the model lacks looks different from each pose, and squares that are not square shear
  // each view according to its roll.
  const bool is_stretched =
      std::ranges::any_of(significantErrors(of, CommonCause::kStretch), [&](const CommonError& stretch) {
        return severityOf(effectOf(of, stretch), of.tolerance_px) >= Severity::kWarning;
      });
  if (of.choice.better_model || of.uncertainty.hasBias() || of.uncertainty.two_cameras || is_stretched)
    return;
  const ViewVariations& variations = of.uncertainty.variations;
  const auto [f, spread] = variations.rows;
  if (isFocalChange(variations) || !(f > kRowsF) || !(spread > kHarmless)) return;
  // It differs from view to view, so the camera gets the mean of as many.
  const double effect_px = kTwoSided95 * spread * onlyCamera(of.fit).size.height /
                           std::sqrt(static_cast<double>(of.fit.views.size()));
  addByEffect(of,
              {.id = "rolling_shutter",
               .cause = "images are sheared: the camera or the board moved during readout",
               .evidence = "by " + percent(spread) + " of the image height",
               .next_step = "keep camera and board still for each photograph"},
              effect_px, diagnoses);
}

namespace {

// The larger bend as a share of the board's size in its direction.
double bendShare(const FitBoard& board) {
  const Board& target = board.target;
  return std::max(std::abs(board.shape.bend_x_m) / target.span().x(),
                  std::abs(board.shape.bend_y_m) / target.span().y());
}

}  // namespace

void bentBoard(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  // Beyond this share of its size, a bent board is no longer the paraboloid that two numbers describe.
  constexpr double kBentShare = 0.005;
  // Of a strong bend, what is taken to deviate from that paraboloid.
  constexpr double kOtherShape = 0.25;
  for (const std::size_t board : estimatedShapes(of.fit)) {
    const double share = bendShare(of.fit.boards[board]);
    const std::vector<double>& flat = of.choice.shapes[board].flat_params;
    if (!(share > kBentShare) || flat.empty()) continue;
    const double bend_effect = effectOfCamera(of, AnyCamera::make(onlyCamera(of.fit).model, flat));
    addByEffect(of,
                {.id = "bent_board",
                 .cause = "the board is strongly bent" + boardSuffix(of.fit, board),
                 .evidence = "by " + numberText("%.2g", 100 * share) + " % of its size",
                 .next_step = "mount the board on something flat and rigid, and photograph it again"},
                kOtherShape * bend_effect, diagnoses);
  }
}

void unevenBoard(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  if (of.choice.points.is_undetermined && !isAnyUneven(of.fit)) {
    diagnoses.push_back({.severity = Severity::kNote,
                         .id = "board_even",
                         .cause = "the views show no unevenness of the board beyond noise; its points are "
                                  "assumed to be in their places"});
  }
  for (std::size_t b = 0; b < of.fit.boards.size(); ++b) {
    const FitBoard& board = of.fit.boards[b];
    if (!board.isUneven()) continue;
    const Eigen::Vector2d rms_m = offsetRms(board.shape);
    diagnoses.push_back({.severity = Severity::kNote,
                         .id = "uneven_board",
                         .cause = "the board is uneven" + boardSuffix(of.fit, b) +
                                  "; the place of each of its points is estimated",
                         .evidence = "off by " + numberText("%.2g", 1e3 * rms_m.x()) +
                                     " mm in the plane and " + numberText("%.2g", 1e3 * rms_m.y()) +
                                     " mm across it (RMS)",
                         .next_step = "mount the board on something flat and rigid: fewer views then do"});
  }
}

void bendIgnored(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  if (!of.uncertainty.ignored_bend) return;
  const IgnoredBend& ignored = *of.uncertainty.ignored_bend;
  std::vector<std::string> bends;
  for (std::size_t i = 0; i < ignored.boards.size(); ++i) {
    bends.push_back(numberText("%.2g", 1e3 * ignored.shapes[i].bend_x_m) + " and " +
                    numberText("%.2g", 1e3 * ignored.shapes[i].bend_y_m) + " mm" +
                    boardSuffix(of.fit, ignored.boards[i]));
  }
  const bool is_one = bends.size() == 1;
  addByEffect(of,
              {.id = "bend_ignored",
               .cause = is_one ? "the board is bent, but --board-shape flat ignores it"
                               : "boards are bent, but --board-shape flat ignores it",
               .evidence = join(bends, "; "),
               .next_step = "use --board-shape auto"},
              effectOfStep(of, ignored.params_step.view().col(0)), diagnoses);
}

void bendUnknown(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  for (std::size_t board = 0; board < of.choice.shapes.size(); ++board) {
    const ShapeReport& shape = of.choice.shapes[board];
    if (shape.is_determined || !shape.is_requested || numViews(of.fit, board) == 0) continue;
    diagnoses.push_back({.severity = Severity::kNote,
                         .id = "bend_unknown",
                         .cause = "the views do not show whether the board" + boardSuffix(of.fit, board) +
                                  " is bent; it is assumed flat",
                         .next_step = "add views tilted in both directions"});
  }
}

}  // namespace alidade
