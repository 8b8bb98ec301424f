// SPDX-License-Identifier: MIT
#include "calibration_output.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "alidade/adjust/errors.h"
#include "alidade/core/size_groups.h"
#include "board_shape_output.h"
#include "command.h"
#include "model_choice_output.h"
#include "summary_output.h"
#include "uncertainty_output.h"

namespace alidade {
namespace {

using nlohmann::json;

constexpr std::size_t kNumWorstViews = 3;
constexpr std::size_t kMaxListed = 12;

double degrees(double rad) {
  return rad * 180 / std::numbers::pi;
}

std::vector<ViewSummary> worstViews(std::vector<ViewSummary> views) {
  std::stable_sort(views.begin(), views.end(),
                   [](const ViewSummary& a, const ViewSummary& b) { return a.rms_px > b.rms_px; });
  views.resize(std::min(views.size(), kNumWorstViews));
  return views;
}

std::string listed(const std::vector<std::string>& lines, const std::string& indent) {
  std::string text;
  for (std::size_t i = 0; i < std::min(lines.size(), kMaxListed); ++i) text += indent + lines[i] + "\n";
  if (lines.size() > kMaxListed)
    text += fmt::format("{}... and {} more\n", indent, lines.size() - kMaxListed);
  return text;
}

std::string startText(const StartReport& start) {
  if (start.num_tried == 0) return "Starts   the camera that was given\n";
  std::string text =
      fmt::format("Starts   {} fields of view tried, the best {} solved, {} of these came to the same answer",
                  start.num_tried, start.num_solved, start.num_agreed);
  if (start.num_optima > 1) text += fmt::format("; {} shapes of the lens compared", start.num_optima);
  return text + "\n";
}

// The least known of what a weak prior holds together.
std::string weakPriorText(const Calibration& result) {
  const WeakPrior& held = onlyCamera(result.fit).weak_prior;
  if (held.isNone()) return "";
  std::string text = fmt::format("Prior    {:g} natural sizes a lens parameter; without it:", held.width);
  const auto names = parameterNames(onlyCamera(result.fit).model);
  for (const int i : held.least_known) {
    const auto at = static_cast<std::size_t>(i);
    text += fmt::format(" {} {:.4g}", names[at], held.free_params[at]);
  }
  return text + "\n";
}

json weakPriorJson(const Calibration& result) {
  const WeakPrior& held = onlyCamera(result.fit).weak_prior;
  if (held.isNone()) return nullptr;
  json least_known = json::array();
  for (const int i : held.least_known)
    least_known.push_back(parameterNames(onlyCamera(result.fit).model)[static_cast<std::size_t>(i)]);
  return {{"width", held.width}, {"least_known", least_known}, {"free_parameters", held.free_params}};
}

std::string domainText(const Calibration& result) {
  const CertifiedCone& cone = result.domain.cone;
  return fmt::format("Domain   one-to-one up to {:.1f} degrees from the axis{}; {}\n",
                     degrees(cone.max_angle_rad), cone.is_limited_by_fold ? " (a fold or pole)" : "",
                     result.domain.full_image ? "every pixel of the image has a ray"
                                              : "NOT every pixel of the image has a ray");
}

nlohmann::json poseJson(const SE3& pose) {
  const Eigen::Quaterniond& q = pose.rotation.quaternion();
  const Eigen::Vector3d& t = pose.translation;
  return {{"quaternion_xyzw", {q.x(), q.y(), q.z(), q.w()}}, {"translation_m", {t.x(), t.y(), t.z()}}};
}

std::string diagnosesText(const Calibration& result) {
  std::string text;
  for (const Diagnosis& diagnosis : result.diagnoses) {
    text +=
        fmt::format("{:<9}{} [{}]\n", severityLabel(diagnosis.severity), diagnosis.message(), diagnosis.id);
    if (!diagnosis.next_step.empty()) text += fmt::format("         next: {}\n", diagnosis.next_step);
  }
  return text;
}

json viewsJson(const Calibration& result) {
  const std::vector<ViewSummary> summaries = viewSummaries(result);
  const std::vector<ViewInfluence>& influences = result.uncertainty.influences;
  json views = json::array();
  for (std::size_t v = 0; v < summaries.size(); ++v) {
    const ViewSummary& view = summaries[v];
    const ViewInfluence influence = influences.empty() ? ViewInfluence{} : influences[v];
    views.push_back(
        {{"image", view.image},
         {"num_corners", view.num_corners},
         {"num_outliers", view.num_outliers},
         {"rms_px", view.rms_px},
         {"max_error_px", view.max_error_px},
         {"camera_from_board", poseJson(cameraFromBoard(result.fit, result.fit.views[v]))},
         {"influence",
          {{"move_sigmas", influence.move_sigmas}, {"surprise_sigmas", influence.surprise_sigmas}}}});
  }
  return views;
}

json repeatedViewsJson(const Calibration& result) {
  json repeated_views = json::array();
  for (const RepeatedView& view : result.dropped.repeated)
    repeated_views.push_back({{"image", view.image}, {"same_as", view.same_as}});
  return repeated_views;
}

json excludedViewsJson(const Calibration& result) {
  json excluded_views = json::array();
  for (const ExcludedView& view : result.dropped.views)
    excluded_views.push_back({{"image", view.image}, {"reason", view.reason}});
  return excluded_views;
}

json diagnosesJson(const Calibration& result) {
  json diagnoses = json::array();
  for (const Diagnosis& diagnosis : result.diagnoses) {
    diagnoses.push_back({{"id", diagnosis.id},
                         {"severity", severityName(diagnosis.severity)},
                         {"cause", diagnosis.cause},
                         {"evidence", diagnosis.evidence},
                         {"effect_px", orNull(diagnosis.effect_px)},
                         {"message", diagnosis.message()},
                         {"next_step", diagnosis.next_step}});
  }
  return diagnoses;
}

json otherOptimaJson(const Calibration& result) {
  json other_optima = json::array();
  for (const OtherOptimum& other : result.uncertainty.other_optima) {
    json parameters = json::object();
    for (std::size_t i = 0; i < other.params.size(); ++i)
      parameters[std::string(parameterNames(onlyCamera(result.fit).model)[i])] = other.params[i];
    other_optima.push_back({{"parameters", std::move(parameters)},
                            {"rms_px", other.rms_px},
                            {"excess_chi2", other.excess_chi2},
                            {"sigmas", orNull(other.sigmas)},
                            {"projection_px", orNull(other.projection_px)}});
  }
  return other_optima;
}

json outliersJson(const Calibration& result) {
  json outliers = json::array();
  for (const Outlier& o : result.dropped.outliers) {
    outliers.push_back(
        {{"image", o.image}, {"corner_id", o.corner_id}, {"dx", o.error_px.x()}, {"dy", o.error_px.y()}});
  }
  return outliers;
}

}  // namespace

std::string detailsText(const Calibration& result, const CalibrationInput& input, const Advice& advice) {
  std::string text = fmt::format("Images   {} given, {} with the board, {} used\n", input.num_images,
                                 input.num_found, result.fit.views.size());
  if (!input.measures.empty()) text += "         " + input.measures + "\n";
  text += listed(input.reasons, "  ");
  text += fmt::format("Noise    {:.3g} px per coordinate (standard deviation of the residuals)\n",
                      result.uncertainty.coordinate_sigma_px);
  if (std::isfinite(result.uncertainty.unexplained_sigma_px)) {
    text += fmt::format("         {:.3g} px of it is not explained by the detector's standard deviations\n",
                        result.uncertainty.unexplained_sigma_px);
  }
  text += boardShapeText(result);
  if (result.choice.model) text += modelChoiceText(*result.choice.model);
  text += weakPriorText(result);
  text += projectionText(result);
  text += domainText(result);
  text += "Views with the largest errors\n";
  for (const ViewSummary& view : worstViews(viewSummaries(result))) {
    text += fmt::format("  {:<24} RMS {:.3g} px, largest {:.3g} px, {} corners\n", view.image, view.rms_px,
                        view.max_error_px, view.num_corners);
  }
  if (!result.dropped.outliers.empty()) {
    std::vector<std::string> lines;
    for (const Outlier& o : result.dropped.outliers) {
      lines.push_back(fmt::format("{} corner {}: error ({:.2f}, {:.2f}) px", o.image, o.corner_id,
                                  o.error_px.x(), o.error_px.y()));
    }
    text += fmt::format("Outliers {} of {} corners ({:.2g} %)\n", result.dropped.outliers.size(),
                        result.dropped.outliers.size() + numCorners(result.fit),
                        100 * result.dropped.outlierShare(result.fit));
    text += listed(lines, "  ");
  }
  text += startText(result.choice.start);
  text +=
      fmt::format("Solver   {} after {} iterations: {}\n", terminationName(result.fit.summary.termination),
                  result.fit.summary.num_iterations, result.fit.summary.reason);
  text += adviceText(advice, result.imageSize());
  for (const std::string& note : input.notes) text += "Note     " + note + "\n";
  return text + diagnosesText(result);
}

std::string summaryJson(const Calibration& result, const CalibrationInput& input, const Advice& advice) {
  json document = {
      {"model", onlyCamera(result.fit).model},
      {"image_size", {{"width", result.imageSize().width}, {"height", result.imageSize().height}}},
      {"board", specText(input.board)},
      {"images",
       {{"given", input.num_images},
        {"found", input.num_found},
        {"used", result.fit.views.size()},
        {"reasons", input.reasons}}},
      {"rms_px", rms(result.fit)},
      {"holdout_rms_px", orNull(result.uncertainty.holdout.rms_px)},
      {"holdout",
       {{"num_folds", result.uncertainty.holdout.num_folds},
        {"num_corners", result.uncertainty.holdout.num_corners},
        {"num_unseen", result.uncertainty.holdout.num_unseen}}},
      {"image_bias",
       {{"z", orNull(result.uncertainty.image_bias.z)},
        {"rms_px", orNull(result.uncertainty.image_bias.rms_px)}}},
      {"model_choice", result.choice.model ? modelChoiceJson(*result.choice.model) : json(nullptr)},
      {"num_corners", numCorners(result.fit)},
      {"coordinate_sigma_px", result.uncertainty.coordinate_sigma_px},
      {"local_sigma_px", orNull(result.uncertainty.local_sigma_px)},
      {"weighted_rms_px", weightedRms(result.fit)},
      {"unexplained_sigma_px", orNull(result.uncertainty.unexplained_sigma_px)},
      {"domain",
       {{"max_angle_rad", result.domain.cone.max_angle_rad},
        {"full_image", result.domain.full_image},
        {"min_relative_det", result.domain.min_relative_det}}},
      {"board_shape", boardShapeJson(result)},
      {"weak_prior", weakPriorJson(result)},
      {"start",
       {{"num_tried", result.choice.start.num_tried},
        {"num_solved", result.choice.start.num_solved},
        {"num_agreed", result.choice.start.num_agreed},
        {"num_optima", result.choice.start.num_optima}}},
      {"other_optima", otherOptimaJson(result)},
      {"solver",
       {{"termination", terminationName(result.fit.summary.termination)},
        {"reason", result.fit.summary.reason},
        {"num_iterations", result.fit.summary.num_iterations}}},
      {"accuracy", accuracyJson(result)},
      {"verdict", verdictName(result.verdict())},
      {"findings", diagnosesJson(result)},
      {"outliers", outliersJson(result)},
      {"outlier_share", result.dropped.outlierShare(result.fit)},
      {"excluded_views", excludedViewsJson(result)},
      {"repeated_views", repeatedViewsJson(result)},
      {"board_stretch", result.uncertainty.board_stretch
                            ? json({{"stretch", result.uncertainty.board_stretch->stretch},
                                    {"sigma", result.uncertainty.board_stretch->sigma}})
                            : json(nullptr)},
      {"variations",
       {{"focal_f", orNull(result.uncertainty.variations.focal.f)},
        {"focal_spread", result.uncertainty.variations.focal.spread},
        {"rows_f", orNull(result.uncertainty.variations.rows.f)},
        {"rows_spread", result.uncertainty.variations.rows.spread},
        {"focal_share", result.uncertainty.variations.focal_share}}},
      {"views", viewsJson(result)},
      {"notes", input.notes},
  };
  addAdvice(advice, document);
  addUncertainty(result, document);
  return jsonText(document);
}

}  // namespace alidade
