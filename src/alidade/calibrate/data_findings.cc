// SPDX-License-Identifier: MIT
#include "alidade/calibrate/data_findings.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>

#include "alidade/core/number_text.h"

namespace alidade {
namespace {

using Severity = Finding::Severity;

std::string percent(double share) {
  return numberText("%.2g", 100 * share) + " %";
}

void judgeLeftOut(const CalibrationResult& result, std::vector<Finding>& findings) {
  if (!result.outliers.empty()) {
    // A few bad corners are what leaving out is for.
    constexpr double kManyOutliers = 0.02;
    findings.push_back(
        {.severity = result.outlierShare() > kManyOutliers ? Severity::kWarning : Severity::kNote,
         .id = "outliers",
         .cause = "corners lie far from where the camera puts them and were left out",
         .evidence = std::to_string(result.outliers.size()) + " corners, " + percent(result.outlierShare()),
         .next_step = "look at the images named in the summary"});
  }
  for (const ExcludedView& view : result.excluded_views) {
    findings.push_back({.severity = Severity::kWarning,
                        .id = "view_left_out",
                        .cause = view.image,
                        .evidence = view.reason,
                        .next_step = "look at the image; remove it, or correct its corners"});
  }
  const std::size_t num_given = result.views.size() + result.excluded_views.size();
  if (2 * result.num_misfits >= num_given && result.num_misfits > 0) {
    findings.push_back({.severity = Severity::kFailure,
                        .id = "views_disagree",
                        .cause = "views contradict each other, and which of them are right cannot be told",
                        .evidence = std::to_string(result.num_misfits) + " of " + std::to_string(num_given) +
                                    " views do not fit the camera of the others",
                        .next_step = "check the board's size, and that all images are of one camera at one "
                                     "zoom and focus"});
  }
}

void judgeRepeated(const CalibrationResult& result, std::vector<Finding>& findings) {
  if (result.repeated_views.empty()) return;
  const RepeatedView& first = result.repeated_views.front();
  const std::size_t count = result.repeated_views.size();
  findings.push_back({.severity = Severity::kNote,
                      .id = "repeated_views",
                      .cause = "views show the board at the same place as others; those of one place were "
                               "averaged and count as one",
                      .evidence = std::to_string(count) + (count == 1 ? " view, " : " views, ") +
                                  first.image + " as " + first.same_as + (count == 1 ? "" : ", ..."),
                      .next_step = "move the board or the camera between photographs; copies add nothing"});
}

// A view that fits, more or less, but only because the camera was bent to it. Without noise there is nothing
// to compare with.
void judgeInfluence(const CalibrationResult& result, std::vector<Finding>& findings) {
  constexpr double kSurprise = 5.1;  // sigmas; of 400 clean sets no view exceeded 4
  constexpr double kMove = 1;        // sigmas; less is no harm
  for (const ViewResult& view : result.views) {
    if (!(view.influence.surprise_sigmas > kSurprise) || !(view.influence.move_sigmas > kMove)) continue;
    findings.push_back(
        {.severity = Severity::kWarning,
         .id = "influential_view",
         .cause = view.image + ": this view disagrees with the others about the camera",
         .evidence = "by " + numberText("%.0f", view.influence.surprise_sigmas) +
                     " sigma; without it the result would move by up to " +
                     numberText("%.1f", view.influence.move_sigmas) + " of its sigma",
         .next_step = "look whether the board is bent, moving or blurred there; calibrate without the image "
                      "to see what changes"});
  }
}

// From behind, a flat board looks like a mirrored one, and nothing else does.
void judgeMirrored(const CalibrationResult& result, std::vector<Finding>& findings) {
  std::vector<std::string> mirrored;
  for (const ViewResult& view : result.views) {
    const SE3& pose = view.camera_from_board;
    if (pose.rotation.matrix().col(2).dot(pose.translation) < 0) mirrored.push_back(view.image);
  }
  const auto add = [&](const std::string& which) {
    findings.push_back({.severity = Severity::kWarning,
                        .id = "mirrored_view",
                        .cause = which + ": the corners are numbered as a mirror shows the board",
                        .evidence = "the pose makes up for it, as if the board were seen from behind",
                        .next_step =
                            "check whether images were flipped, and in which order corners are numbered; the "
                            "camera's parameters do not suffer, its poses do"});
  };
  if (mirrored.size() == result.views.size()) {
    add("all views");
  } else {
    for (const std::string& image : mirrored) add(image);
  }
}

void judgeBoard(const CalibrationResult& result, std::vector<Finding>& findings) {
  constexpr double kSignificant = 4;  // sigmas
  constexpr double kHarmless = 1e-3;  // what paper stretches by in damp air
  if (!result.board_stretch) return;
  const auto [stretch, noise_sigma] = *result.board_stretch;
  // A lens that does not follow its model errs in the same way in all views, so that they agree on it.
  const double sigma = noise_sigma * std::max(1.0, result.smoothness());
  if (!(std::abs(stretch) > kSignificant * sigma) || std::abs(stretch) < kHarmless) return;
  findings.push_back({.severity = Severity::kWarning,
                      .id = "board_not_square",
                      .cause = "the board's squares seem not to be square",
                      .evidence = numberText("%.4f", 1 + stretch) + " (+- " + numberText("%.4f", sigma) +
                                  ") times as wide (from column to column) as high (from row to row)",
                      .next_step = "measure the board along both directions over many squares; printers "
                                   "stretch one of them. Print it again, and calibrate with that"});
}

// One camera has one focal length, and a board that stands still is not sheared.
void judgeVariations(const CalibrationResult& result, std::vector<Finding>& findings) {
  // Boards and lenses that are not quite what they are taken for make single views differ a little too: on
  // good photographs F comes to 6, on changed or sheared ones of the same size to 30 and more.
  constexpr double kFocalF = 8;
  constexpr double kRowsF = 20;
  // About a half where images are sheared at random, 1 where focal lengths vary.
  constexpr double kFocalShare = 0.8;
  constexpr double kFocalHarmless = 2e-3;  // of the focal length
  constexpr double kFocalHarmful = 1e-2;
  constexpr double kRowsHarmless = 2e-3;  // of the image's height
  const ViewVariations& variations = result.variations;
  const bool is_focal = variations.focal_share > kFocalShare;
  if (is_focal && variations.focal.f > kFocalF && variations.focal.spread > kFocalHarmless) {
    findings.push_back(
        {.severity = variations.focal.spread > kFocalHarmful ? Severity::kFailure : Severity::kWarning,
         .id = "focal_changed",
         .cause = "the focal length differs from view to view: zoom or focus changed, or images of several "
                  "cameras or crops are mixed",
         .evidence = "by " + percent(variations.focal.spread) + " (one standard deviation; F " +
                     numberText("%.0f", variations.focal.f) + ")",
         .next_step = "fix zoom and focus (autofocus off), and calibrate the images of each setting apart"});
  }
  // What the lens does that the model does not looks different from each pose.
  if (result.better_model || result.hasBias()) return;
  // Squares that are not square shear each view by its own roll.
  const bool is_explained = std::any_of(findings.begin(), findings.end(),
                                        [](const Finding& f) { return f.id == "board_not_square"; });
  if (!is_focal && !is_explained && variations.rows.f > kRowsF && variations.rows.spread > kRowsHarmless) {
    findings.push_back(
        {.severity = Severity::kWarning,
         .id = "rolling_shutter",
         .cause = "images are sheared or stretched differently from view to view, as when something moves "
                  "while the rows are read one after the other",
         .evidence = "by " + percent(variations.rows.spread) + " of the image's height (F " +
                     numberText("%.0f", variations.rows.f) + ")",
         .next_step = "rest camera and board on something while each image is taken, with short exposure"});
  }
}

}  // namespace

void judgeData(const CalibrationResult& result, std::vector<Finding>& findings) {
  judgeLeftOut(result, findings);
  judgeRepeated(result, findings);
  judgeInfluence(result, findings);
  judgeMirrored(result, findings);
  judgeBoard(result, findings);
  judgeVariations(result, findings);
}

}  // namespace alidade
