// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "alidade/calibrate/judge/diagnoses.h"
#include "alidade/core/number_text.h"

namespace alidade {
namespace {

std::string percent(double share) {
  return numberText("%.2g", 100 * share) + " %";
}

}  // namespace

void outliers(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  if (!of.dropped.outliers.empty()) {
    // A few bad corners are what leaving out is for.
    constexpr double kManyOutliers = 0.02;
    diagnoses.push_back(
        {.severity = of.dropped.outlierShare(of.fit) > kManyOutliers ? Severity::kWarning : Severity::kNote,
         .id = "outliers",
         .cause = "corners lie far from where the camera puts them and were left out",
         .evidence = std::to_string(of.dropped.outliers.size()) + " corners, " +
                     percent(of.dropped.outlierShare(of.fit)),
         .next_step = "look at the images named in the summary"});
  }
}

void viewsLeftOut(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  for (const ExcludedView& view : of.dropped.views) {
    diagnoses.push_back({.severity = Severity::kWarning,
                         .id = "view_left_out",
                         .cause = view.image,
                         .evidence = view.reason,
                         .next_step = "look at the image; remove it, or correct its corners"});
  }
}

void viewsDisagree(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  const std::size_t num_given = of.fit.views.size() + of.dropped.views.size();
  if (2 * of.dropped.numMisfits() >= num_given && of.dropped.numMisfits() > 0) {
    diagnoses.push_back({.severity = Severity::kFailure,
                         .id = "views_disagree",
                         .cause = "views contradict each other, and which of them are right cannot be told",
                         .evidence = std::to_string(of.dropped.numMisfits()) + " of " +
                                     std::to_string(num_given) + " views do not fit the camera of the others",
                         .next_step = "check the board's size, and that all images are of one camera at one "
                                      "zoom and focus"});
  }
}

void repeatedViews(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  if (of.dropped.repeated.empty()) return;
  const RepeatedView& first = of.dropped.repeated.front();
  const std::size_t count = of.dropped.repeated.size();
  diagnoses.push_back({.severity = Severity::kNote,
                       .id = "repeated_views",
                       .cause = "views show the board at the same place as others; those of one place were "
                                "averaged and count as one",
                       .evidence = std::to_string(count) + (count == 1 ? " view, " : " views, ") +
                                   first.image + " as " + first.same_as + (count == 1 ? "" : ", ..."),
                       .next_step = "move the board or the camera between photographs; copies add nothing"});
}

// A view that fits, more or less, but only because the camera was bent to it. Without noise there is nothing
// to compare with.
void influentialViews(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  constexpr double kSurprise = 5.1;  // sigmas; of 400 clean sets no view exceeded 4
  constexpr double kMove = 1;        // sigmas; less is no harm
  const std::vector<ViewInfluence>& influences = of.uncertainty.influences;
  for (std::size_t v = 0; v < influences.size(); ++v) {
    const auto [move_sigmas, surprise_sigmas] = influences[v];
    if (!(surprise_sigmas > kSurprise) || !(move_sigmas > kMove)) continue;
    diagnoses.push_back(
        {.severity = Severity::kWarning,
         .id = "influential_view",
         .cause = of.fit.views[v].image + ": this view disagrees with the others about the camera",
         .evidence = "by " + numberText("%.0f", surprise_sigmas) +
                     " sigma; without it the result would move by up to " + numberText("%.1f", move_sigmas) +
                     " of its sigma",
         .next_step = "look whether the board is bent, moving or blurred there; calibrate without the image "
                      "to see what changes"});
  }
}

// From behind, a flat board looks like a mirrored one, and nothing else does.
void mirroredViews(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  std::vector<std::string> mirrored;
  for (const FitView& view : of.fit.views) {
    const SE3 pose = cameraFromBoard(of.fit, view);
    if (pose.rotation.matrix().col(2).dot(pose.translation) < 0) mirrored.push_back(view.image);
  }
  const auto add = [&](const std::string& which) {
    diagnoses.push_back(
        {.severity = Severity::kWarning,
         .id = "mirrored_view",
         .cause = which + ": the corners are numbered as a mirror shows the board",
         .evidence = "the pose makes up for it, as if the board were seen from behind",
         .next_step = "check whether images were flipped, and in which order corners are numbered; the "
                      "camera's parameters do not suffer, its poses do"});
  };
  if (mirrored.size() == of.fit.views.size()) {
    add("all views");
  } else {
    for (const std::string& image : mirrored) add(image);
  }
}

namespace {

// The stretch of the squares and its one sigma, if it is more than chance and does harm.
std::optional<BoardStretch> harmfulStretch(const Evidence& of) {
  constexpr double kSignificant = 4;  // sigmas
  constexpr double kHarmless = 1e-3;  // what paper stretches by in damp air
  if (!of.uncertainty.board_stretch) return std::nullopt;
  const auto [stretch, noise_sigma] = *of.uncertainty.board_stretch;
  // A lens that does not follow its model errs in the same way in all views, so that they agree on it.
  const double sigma = noise_sigma * std::max(1.0, of.smoothness());
  if (!(std::abs(stretch) > kSignificant * sigma) || std::abs(stretch) < kHarmless) return std::nullopt;
  return BoardStretch{.stretch = stretch, .sigma = sigma};
}

}  // namespace

void boardNotSquare(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  const auto board = harmfulStretch(of);
  if (!board) return;
  diagnoses.push_back({.severity = Severity::kWarning,
                       .id = "board_not_square",
                       .cause = "the board's squares seem not to be square",
                       .evidence = numberText("%.4f", 1 + board->stretch) + " (+- " +
                                   numberText("%.4f", board->sigma) +
                                   ") times as wide (from column to column) as high (from row to row)",
                       .next_step = "measure the board along both directions over many squares; printers "
                                    "stretch one of them. Print it again, and calibrate with that"});
}

namespace {

// Boards and lenses that are not quite what they are taken for make single views differ a little too: on good
// photographs F comes to 6, on changed or sheared ones of the same size to 30 and more.

// One camera has one focal length. The share is about a half where images are sheared at random, 1 where
// focal lengths vary.
bool isFocalChange(const ViewVariations& variations) {
  constexpr double kFocalShare = 0.8;
  return variations.focal_share > kFocalShare;
}

}  // namespace

void focalChanged(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  constexpr double kFocalF = 8;
  constexpr double kHarmless = 2e-3;  // of the focal length
  constexpr double kHarmful = 1e-2;
  const ViewVariations& variations = of.uncertainty.variations;
  const auto [f, spread] = variations.focal;
  if (!isFocalChange(variations) || !(f > kFocalF) || !(spread > kHarmless)) return;
  diagnoses.push_back(
      {.severity = spread > kHarmful ? Severity::kFailure : Severity::kWarning,
       .id = "focal_changed",
       .cause = "the focal length differs from view to view: zoom or focus changed, or images of several "
                "cameras or crops are mixed",
       .evidence = "by " + percent(spread) + " (one standard deviation; F " + numberText("%.0f", f) + ")",
       .next_step = "fix zoom and focus (autofocus off), and calibrate the images of each setting apart"});
}

// A board that stands still is not sheared.
void rollingShutter(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  constexpr double kRowsF = 20;
  constexpr double kHarmless = 2e-3;  // of the image's height
  // What the lens does that the model does not looks different from each pose, and squares that are not
  // square shear each view by its own roll.
  if (of.choice.better_model || of.uncertainty.hasBias() || harmfulStretch(of)) return;
  const ViewVariations& variations = of.uncertainty.variations;
  const auto [f, spread] = variations.rows;
  if (isFocalChange(variations) || !(f > kRowsF) || !(spread > kHarmless)) return;
  diagnoses.push_back(
      {.severity = Severity::kWarning,
       .id = "rolling_shutter",
       .cause = "images are sheared or stretched differently from view to view, as when something moves "
                "while the rows are read one after the other",
       .evidence = "by " + percent(spread) + " of the image's height (F " + numberText("%.0f", f) + ")",
       .next_step = "rest camera and board on something while each image is taken, with short exposure"});
}

namespace {

// The larger bend as a share of the board's extent along it.
double bendShare(const FitBoard& board) {
  const Checkerboard& target = board.target;
  return std::max(std::abs(board.shape.bend_x_m) / (target.square_m * (target.columns - 1)),
                  std::abs(board.shape.bend_y_m) / (target.square_m * (target.rows - 1)));
}

}  // namespace

void bentBoard(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  // Bent by this share of its size it is no longer the paraboloid that two numbers describe.
  constexpr double kBentShare = 0.005;
  if (!isShapeEstimated(of.fit)) return;
  const double share = bendShare(onlyBoard(of.fit));
  if (!(share > kBentShare)) return;
  diagnoses.push_back(
      {.severity = Severity::kWarning,
       .id = "bent_board",
       .cause = "the board is bent too much to be a paraboloid, which is what is allowed for",
       .evidence = "its middle stands out by " + numberText("%.2g", 100 * share) + " % of its size",
       .next_step = "mount the board on something flat and rigid, and photograph it again"});
}

void bendIgnored(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  if (of.uncertainty.ignored_bend) {
    const BoardShape& bend = of.uncertainty.ignored_bend->shape;
    diagnoses.push_back(
        {.severity = Severity::kWarning,
         .id = "bend_ignored",
         .cause = "the board is bent but was taken as flat; the stated uncertainty allows for it",
         .evidence = numberText("%.2g", 1e3 * bend.bend_x_m) + " mm from left to right and " +
                     numberText("%.2g", 1e3 * bend.bend_y_m) +
                     " mm from top to bottom; with the bend fx would change by " +
                     numberText("%.2g", of.uncertainty.ignored_bend->params_step(0, 0)) + " px",
         .next_step = "use --board-shape auto, and a model that suits the lens"});
  }
}

void bendUnknown(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  if (!of.choice.shape.is_determined && of.choice.shape.is_requested) {
    diagnoses.push_back(
        {.severity = Severity::kWarning,
         .id = "bend_unknown",
         .cause = "these views do not tell whether the board is bent, so it was taken as flat",
         .evidence = {},
         .next_step = "take more views, tilted both ways, of a board with three or more "
                      "corners a side"});
  }
}

}  // namespace alidade
