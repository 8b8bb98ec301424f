// SPDX-License-Identifier: MIT
#include <cstddef>
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

// Name of a view's image, with its board if there are several.
std::string nameOf(const Fit& fit, const FitView& view) {
  return view.image + boardSuffix(fit, boardIndex(fit, view));
}

// With few views nothing contradicts a mistake, so all results may be wrong.
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
  constexpr double kMany = 0.1;      // more than any good board lost in real photographs
  constexpr double kTooMany = 0.25;  // the remaining corners may fit only by coincidence
  if (of.dropped.outliers.empty()) return;
  const double share = of.dropped.outlierShare(of.fit);
  diagnoses.push_back(
      {.id = "outliers",
       .severity = share > kTooMany ? Severity::kFailure
                   : share > kMany  ? Severity::kWarning
                                    : Severity::kNote,
       .cause = "corners were left out as outliers",
       .evidence = counted(of.dropped.outliers.size(), "corner") + " (" + percent(share) + ")",
       .next_step = "check the images that --verbose lists"});
}

void viewsLeftOut(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  for (const ExcludedView& view : of.dropped.views) {
    diagnoses.push_back({.id = "view_left_out",
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
      {.id = "views_disagree",
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
  // One camera cannot be the mean of two.
  if (added.severity == Severity::kWarning) added.severity = Severity::kFailure;
}

void repeatedViews(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  if (of.dropped.repeated.empty()) return;
  const RepeatedView& first = of.dropped.repeated.front();
  const std::size_t count = of.dropped.repeated.size();
  diagnoses.push_back({.id = "repeated_views",
                       .cause = "views of the same board position were averaged and count as one",
                       .evidence = counted(count, "view") + (count == 1 ? ", " : ", for example ") +
                                   first.image + boardSuffix(of.fit, first.board) + " (same as " +
                                   first.same_as + ")",
                       .next_step = "move the board or the camera between photographs"});
}

// Reports a view that fits only because it biased the camera. Without noise there is nothing to compare with.
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
                // Upper bound: no projection moves by more than this in its own standard deviations.
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
    diagnoses.push_back({.id = "mirrored_view",
                         .cause = which,
                         .evidence = "the corners are numbered as in a mirror image",
                         .next_step = "check whether images were flipped; if not, only the poses are wrong"});
  }
}

}  // namespace

void diagnoseViews(const Evidence& of, std::vector<Diagnosis>& diagnoses) {
  for (const auto& diagnose : {fewViews, outliers, viewsLeftOut, viewsDisagree, twoCamerasMixed,
                               repeatedViews, influentialViews, mirroredViews})
    diagnose(of, diagnoses);
}

}  // namespace alidade::detail
