// SPDX-License-Identifier: MIT
#include "calibration_output.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "alidade/core/size_groups.h"
#include "board_shape_output.h"
#include "command.h"
#include "model_choice_output.h"
#include "uncertainty_output.h"

namespace alidade {
namespace {

using nlohmann::json;

constexpr std::size_t kNumWorstViews = 3;
constexpr std::size_t kMaxListed = 12;

double degrees(double rad) {
  return rad * 180 / std::numbers::pi;
}

std::vector<const ViewResult*> worstViews(const CalibrationResult& result) {
  std::vector<const ViewResult*> views;
  for (const ViewResult& view : result.views) views.push_back(&view);
  std::stable_sort(views.begin(), views.end(),
                   [](const auto* a, const auto* b) { return a->rms_px > b->rms_px; });
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
std::string weakPriorText(const CalibrationResult& result) {
  const WeakPrior& held = result.weak_prior;
  if (held.isNone()) return "";
  std::string text = fmt::format("Prior    {:g} natural sizes a lens parameter; without it:", held.width);
  const auto names = result.camera.parameterNames();
  for (const int i : held.least_known) {
    const auto at = static_cast<std::size_t>(i);
    text += fmt::format(" {} {:.4g}", names[at], held.free_params[at]);
  }
  return text + "\n";
}

json weakPriorJson(const CalibrationResult& result) {
  const WeakPrior& held = result.weak_prior;
  if (held.isNone()) return nullptr;
  json least_known = json::array();
  for (const int i : held.least_known)
    least_known.push_back(result.camera.parameterNames()[static_cast<std::size_t>(i)]);
  return {{"width", held.width}, {"least_known", least_known}, {"free_parameters", held.free_params}};
}

std::string domainText(const CalibrationResult& result) {
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

std::string verdictText(const CalibrationResult& result) {
  std::string text;
  for (const Finding& finding : result.findings) {
    const char* label = finding.severity == Finding::Severity::kFailure   ? "FAILED  "
                        : finding.severity == Finding::Severity::kWarning ? "Warning "
                                                                          : "Note    ";
    text += fmt::format("{} {} [{}]\n         next: {}\n", label, finding.message(), finding.id,
                        finding.next_step);
  }
  switch (result.verdict()) {
    case Verdict::kTrustworthy:
      return text + "Verdict  trustworthy\n";
    case Verdict::kReservations:
      return text + "Verdict  usable with reservations: see the warnings above\n";
    case Verdict::kNo:
      return text + "Verdict  no: not to be used, see what failed above\n";
  }
  return text;
}

json orNull(double value) {
  return std::isfinite(value) ? json(value) : json(nullptr);
}

json viewsJson(const CalibrationResult& result) {
  json views = json::array();
  for (const ViewResult& view : result.views) {
    views.push_back({{"image", view.image},
                     {"num_corners", view.num_corners},
                     {"num_outliers", view.num_outliers},
                     {"rms_px", view.rms_px},
                     {"max_error_px", view.max_error_px},
                     {"camera_from_board", poseJson(view.camera_from_board)},
                     {"influence",
                      {{"move_sigmas", view.influence.move_sigmas},
                       {"surprise_sigmas", view.influence.surprise_sigmas}}}});
  }
  return views;
}

json repeatedViewsJson(const CalibrationResult& result) {
  json repeated_views = json::array();
  for (const RepeatedView& view : result.repeated_views)
    repeated_views.push_back({{"image", view.image}, {"same_as", view.same_as}});
  return repeated_views;
}

json excludedViewsJson(const CalibrationResult& result) {
  json excluded_views = json::array();
  for (const ExcludedView& view : result.excluded_views)
    excluded_views.push_back({{"image", view.image}, {"reason", view.reason}});
  return excluded_views;
}

json findingsJson(const CalibrationResult& result) {
  json findings = json::array();
  for (const Finding& finding : result.findings) {
    findings.push_back({{"id", finding.id},
                        {"severity", severityName(finding.severity)},
                        {"cause", finding.cause},
                        {"evidence", finding.evidence},
                        {"message", finding.message()},
                        {"next_step", finding.next_step}});
  }
  return findings;
}

json otherOptimaJson(const CalibrationResult& result) {
  json other_optima = json::array();
  for (const OtherOptimum& other : result.other_optima) {
    json parameters = json::object();
    for (std::size_t i = 0; i < other.params.size(); ++i)
      parameters[std::string(result.camera.parameterNames()[i])] = other.params[i];
    other_optima.push_back({{"parameters", std::move(parameters)},
                            {"rms_px", other.rms_px},
                            {"excess_chi2", other.excess_chi2},
                            {"sigmas", orNull(other.sigmas)},
                            {"projection_px", orNull(other.projection_px)}});
  }
  return other_optima;
}

json outliersJson(const CalibrationResult& result) {
  json outliers = json::array();
  for (const Outlier& o : result.outliers) {
    outliers.push_back(
        {{"image", o.image}, {"corner_id", o.corner_id}, {"dx", o.error_px.x()}, {"dy", o.error_px.y()}});
  }
  return outliers;
}

}  // namespace

std::string summaryText(const CalibrationResult& result, const CalibrationInput& input,
                        const Advice& advice) {
  std::string text = fmt::format("Camera   {}, {} px, board {}\n", result.camera.modelId(),
                                 sizeText(result.image_size), specText(input.board));
  text += fmt::format("Images   {} given, {} with the board, {} used\n", input.num_images, input.num_found,
                      result.views.size());
  if (!input.measures.empty()) text += "         " + input.measures + "\n";
  text += listed(input.reasons, "  ");
  text += fmt::format(
      "RMS      {:.4g} px over {} corners (sqrt of the mean of dx^2 + dy^2); sigma {:.3g} px an axis\n",
      result.rms_px, result.num_corners, result.coordinate_sigma_px);
  text += holdoutText(result.holdout);
  if (std::isfinite(result.unexplained_sigma_px)) {
    text += fmt::format("Noise    {:.3g} px an axis beyond what detection states of its corners\n",
                        result.unexplained_sigma_px);
  }
  text += boardShapeText(result);
  if (result.model_choice) text += modelChoiceText(*result.model_choice);
  text += parameterTable(result);
  text += weakPriorText(result);
  text += projectionText(result);
  text += domainText(result);
  text += "Worst views\n";
  for (const ViewResult* view : worstViews(result)) {
    text += fmt::format("  {:<24} RMS {:.3g} px, worst corner {:.3g} px, {} corners\n", view->image,
                        view->rms_px, view->max_error_px, view->num_corners);
  }
  if (!result.outliers.empty()) {
    std::vector<std::string> lines;
    for (const Outlier& o : result.outliers) {
      lines.push_back(fmt::format("{} corner {}: off by ({:.2f}, {:.2f}) px", o.image, o.corner_id,
                                  o.error_px.x(), o.error_px.y()));
    }
    text += fmt::format("Left out {} corners of {} ({:.2g} %)\n", result.outliers.size(),
                        result.outliers.size() + static_cast<std::size_t>(result.num_corners),
                        100 * result.outlierShare());
    text += listed(lines, "  ");
  }
  text += startText(result.start);
  text += fmt::format("Solver   {} after {} iterations: {}\n", terminationName(result.solver.termination),
                      result.solver.num_iterations, result.solver.reason);
  text += adviceText(advice, result.image_size);
  for (const std::string& note : input.notes) text += "Note     " + note + "\n";
  return text + verdictText(result);
}

std::string summaryJson(const CalibrationResult& result, const CalibrationInput& input,
                        const Advice& advice) {
  json document = {
      {"model", result.camera.modelId()},
      {"image_size", {{"width", result.image_size.width}, {"height", result.image_size.height}}},
      {"board", specText(input.board)},
      {"images",
       {{"given", input.num_images},
        {"found", input.num_found},
        {"used", result.views.size()},
        {"reasons", input.reasons}}},
      {"rms_px", result.rms_px},
      {"holdout_rms_px", orNull(result.holdout.rms_px)},
      {"holdout",
       {{"num_folds", result.holdout.num_folds},
        {"num_corners", result.holdout.num_corners},
        {"num_unseen", result.holdout.num_unseen}}},
      {"image_bias", {{"z", orNull(result.image_bias.z)}, {"rms_px", orNull(result.image_bias.rms_px)}}},
      {"model_choice", result.model_choice ? modelChoiceJson(*result.model_choice) : json(nullptr)},
      {"num_corners", result.num_corners},
      {"coordinate_sigma_px", result.coordinate_sigma_px},
      {"local_sigma_px", orNull(result.local_sigma_px)},
      {"weighted_rms_px", result.weighted_rms_px},
      {"unexplained_sigma_px", orNull(result.unexplained_sigma_px)},
      {"domain",
       {{"max_angle_rad", result.domain.cone.max_angle_rad},
        {"full_image", result.domain.full_image},
        {"min_relative_det", result.domain.min_relative_det}}},
      {"board_shape", boardShapeJson(result.shape)},
      {"weak_prior", weakPriorJson(result)},
      {"start",
       {{"num_tried", result.start.num_tried},
        {"num_solved", result.start.num_solved},
        {"num_agreed", result.start.num_agreed},
        {"num_optima", result.start.num_optima}}},
      {"other_optima", otherOptimaJson(result)},
      {"solver",
       {{"termination", terminationName(result.solver.termination)},
        {"reason", result.solver.reason},
        {"num_iterations", result.solver.num_iterations}}},
      {"verdict", verdictName(result.verdict())},
      {"findings", findingsJson(result)},
      {"outliers", outliersJson(result)},
      {"outlier_share", result.outlierShare()},
      {"excluded_views", excludedViewsJson(result)},
      {"repeated_views", repeatedViewsJson(result)},
      {"board_stretch", result.board_stretch ? json({{"stretch", result.board_stretch->stretch},
                                                     {"sigma", result.board_stretch->sigma}})
                                             : json(nullptr)},
      {"variations",
       {{"focal_f", orNull(result.variations.focal.f)},
        {"focal_spread", result.variations.focal.spread},
        {"rows_f", orNull(result.variations.rows.f)},
        {"rows_spread", result.variations.rows.spread},
        {"focal_share", result.variations.focal_share}}},
      {"views", viewsJson(result)},
      {"notes", input.notes},
  };
  addAdvice(advice, document);
  addUncertainty(result, document);
  return jsonText(document);
}

}  // namespace alidade
