// SPDX-License-Identifier: MIT
#include <algorithm>
#include <limits>
#include <utility>

#include "alidade/core/mapped.h"
#include "alidade/report/data/json_output.h"
#include "commands/validate/validation_output.h"

namespace alidade {
namespace {

json checksJson(const std::vector<FileCheck>& list) {
  json checks = json::array();
  for (const FileCheck& check : list) {
    json values = json::object();
    for (const auto& [name, value] : check.values) values[name] = value;
    checks.push_back({{"id", check.id},
                      {"status", severityName(check.severity)},
                      {"values", std::move(values)},
                      {"message", check.message}});
    if (check.mended) {
      checks.back()["slip"] = {
          {"id", check.slip},
          {"parameters", parametersJson(check.mended->parameterNames(), check.mended->parameters())}};
    }
  }
  return checks;
}

json cameraChangeJson(const CameraChange& change) {
  return {{"id", changeId(change.kind)},
          {"text", describe(change)},
          {"amounts", change.amounts},
          {"std", change.std},
          {"parameters", parametersJson(change.camera.parameterNames(), change.camera.parameters())},
          {"cost_drop", change.cost_drop},
          {"score", change.score},
          {"effect_px", change.effect_px},
          {"sure_px", change.sure_px},
          {"blind_px", change.blind_px}};
}

json cellsJson(const FootageCheck& check) {
  return mapped(check.cells, [](const FootageCell& cell) -> json {
    const auto orNone = [&](double value) { return cell.num_pixels > 0 ? json(value) : json(nullptr); };
    return {{"num_pixels", cell.num_pixels},
            {"rms_px", orNone(cell.rms_px)},
            {"dx", orNone(cell.mean_px.x())},
            {"dy", orNone(cell.mean_px.y())}};
  });
}

json footageCheckJson(const FootageCheck& check) {
  const bool is_tested = check.num_windows > 0;
  const auto orNone = [&](double value) { return is_tested ? json(value) : json(nullptr); };
  return {{"verdict", verdictId(check.verdict)},
          {"gap", check.gap == FootageGap::kNone ? json(nullptr) : json(gapId(check.gap))},
          {"explanation",
           check.explanation ? json(changeId(check.changes.at(*check.explanation).kind)) : json(nullptr)},
          {"changes", mapped(check.changes, cameraChangeJson)},
          {"blind_px", check.changes.empty() ? json(nullptr) : json(check.blind_px)},
          {"num_frames", check.num_frames},
          {"num_windows", check.num_windows},
          {"num_points", check.num_points},
          {"num_pixels", check.num_pixels},
          {"parallax_px", check.parallax_px},
          {"noise_px", orNone(check.noise_px)},
          {"holdout_rms_px", orNone(check.holdout_rms_px)},
          {"readout_frames", check.is_video && is_tested ? json(check.readout) : json(nullptr)},
          {"cell_columns", FootageCheck::kColumns},
          {"cell_rows", FootageCheck::kRows},
          {"cells", cellsJson(check)}};
}

json footageJson(const FootageJudgement& judgement) {
  json edits = json::array();
  for (const FootageEdit& edit : judgement.edits) {
    json crop = nullptr;
    if (const auto& part = edit.request.crop)
      crop = {{"x", part->x}, {"y", part->y}, {"width", part->width}, {"height", part->height}};
    std::string id = editWords(edit.request);
    std::ranges::replace(id, ' ', '_');
    edits.push_back({{"id", std::move(id)},
                     {"crop", std::move(crop)},
                     {"resize", orNull(edit.request.resize)},
                     {"rotate_deg", edit.request.rotate_deg ? json(*edit.request.rotate_deg) : json(nullptr)},
                     {"flags", editFlags(edit.request)},
                     {"check", footageCheckJson(edit.check)}});
  }
  return {{"verdict", verdictId(judgement.verdict())},
          {"image_size", judgement.image_size},
          {"num_frames_given", judgement.num_frames_given},
          {"tolerance_px", judgement.check.tolerance_px},
          {"check", judgement.isOtherSize() ? json(nullptr) : footageCheckJson(judgement.check)},
          {"edits", std::move(edits)}};
}

json heldOutViewJson(const HeldOutView& view, const std::vector<Board>& boards, bool has_corners) {
  double largest_px = view.corners.empty() ? std::numeric_limits<double>::quiet_NaN() : 0;
  for (const CornerError& corner : view.corners) largest_px = std::max(largest_px, corner.error_px.norm());
  json document = {{"image", view.image},
                   {"num_corners", view.num_corners},
                   {"num_unseen", view.num_unseen},
                   {"rms_px", view.rms_px},
                   {"max_error_px", largest_px},
                   {"fixed_rms_px", view.fixed_rms_px},
                   {"freed_rms_px", view.freed_rms_px}};
  if (boards.size() > 1) document["board"] = boards[view.board].spec();
  if (!view.corners.empty()) document["camera_from_board"] = view.camera_from_board;
  if (has_corners) document["corners"] = view.corners;
  return document;
}

// The camera calibrated from the images alone.
json freedJson(const Calibration& freed) {
  const AnyCamera camera = freed.camera();
  const Uncertainty& known = freed.uncertainty;
  std::vector<double> stds;
  for (std::size_t i = 0; i < camera.parameters().size(); ++i)
    stds.push_back(known.parameterStd(static_cast<int>(i)));
  json document = {{"model", camera.modelId()},
                   {"parameters", parametersJson(camera.parameterNames(), camera.parameters())},
                   {"parameter_std", parametersJson(camera.parameterNames(), stds)},
                   {"covariance", nullptr}};
  if (known.covariance) document["covariance"] = lowerTriangle(known.statedCovariance());
  return document;
}

json heldOutJson(const HeldOutJudgement& judgement, const std::vector<Board>& boards, bool has_corners) {
  json views = json::array();
  for (const HeldOutView& view : judgement.views) views.push_back(heldOutViewJson(view, boards, has_corners));
  const auto tested = [&](const FitBoard& board) { return board.target.spec(); };
  return {{"boards",
           judgement.freed ? mapped(judgement.freed->fit.boards, tested) : mapped(boards, &Board::spec)},
          {"num_views_given", judgement.num_views_given},
          {"num_corners", judgement.numCorners()},
          {"rms_px", judgement.held_out_rms_px},
          {"noise_sigma_px", judgement.noise_sigma_px},
          {"noise_rms_px", judgement.noise_rms_px},
          {"fixed_rms_px", judgement.fixed_rms_px},
          {"freed_rms_px", judgement.freedRmsPx()},
          {"covered_share", judgement.covered_share},
          {"p95_px", judgement.difference ? json(judgement.difference->p95_px) : json(nullptr)},
          {"freed", judgement.freed ? freedJson(*judgement.freed) : json(nullptr)},
          {"views", std::move(views)}};
}

json cameraJson(const CameraJudgement& camera, const std::vector<Board>& boards, bool has_corners) {
  json document = {
      {"name", camera.name},
      {"model", nullptr},
      {"image_size", orNull(camera.image_size)},
      {"calibration", nullptr},
      {"held_out", camera.held_out ? heldOutJson(*camera.held_out, boards, has_corners) : json(nullptr)},
      {"footage", camera.footage ? footageJson(*camera.footage) : json(nullptr)},
      {"checks", checksJson(camera.checks)}};
  if (const auto& stated = camera.calibration) {
    const auto orNone = [](const std::vector<double>& values) {
      return values.empty() ? json(nullptr) : json(values);
    };
    document["calibration"] = {{"verdict", verdictName(stated->verdict)},
                               {"accuracy_px", stated->accuracy_px},
                               {"accuracy_distance_m", stated->accuracy_distance_m},
                               {"covered_share", stated->covered_share},
                               {"parameter_std", orNone(stated->parameter_std)},
                               {"covariance", orNone(stated->covariance)}};
  }
  if (camera.camera) {
    document["model"] = camera.camera->modelId();
    document["parameters"] = parametersJson(camera.camera->parameterNames(), camera.camera->parameters());
  }
  return document;
}

json validationDocument(const ValidationResult& result, bool has_corners) {
  const auto textOrNull = [](const std::string& text) { return text.empty() ? json(nullptr) : json(text); };
  json files = json::array();
  for (const FileJudgement& file : result.files) {
    json cameras = json::array();
    for (const CameraJudgement& camera : file.cameras)
      cameras.push_back(cameraJson(camera, result.boards, has_corners));
    files.push_back({{"file", file.file},
                     {"status", severityName(result.outcomeOf(file))},
                     {"format", textOrNull(file.format)},
                     {"error", textOrNull(file.error)},
                     {"cameras", std::move(cameras)},
                     {"rig_checks", checksJson(file.rig_checks)}});
  }
  const std::size_t num_failed = numWith(result, Severity::kFailure);
  return {{"created_by", result.origin.created_by},
          {"strict", result.is_strict},
          {"tolerance_px", result.tolerance_px},
          {"totals",
           {{"files", result.files.size()},
            {"passed", result.files.size() - num_failed},
            {"passed_with_warnings", numWith(result, Severity::kWarning)},
            {"failed", num_failed},
            {"other_files", result.other_files.size()}}},
          {"files", std::move(files)},
          {"other_files", result.other_files}};
}

}  // namespace

std::string judgementJson(const ValidationResult& result) {
  return jsonText(validationDocument(result, false));
}

json validationEvidence(const ValidationResult& result) {
  json document = validationDocument(result, true);
  document["against"] = nullptr;
  if (const auto& rival = result.rival) {
    const AnyCamera& camera = rival->camera;
    document["against"] = {{"file", rival->name},
                           {"model", camera.modelId()},
                           {"image_size", rival->size},
                           {"parameters", parametersJson(camera.parameterNames(), camera.parameters())},
                           {"covariance", nullptr}};
    if (rival->covariance) document["against"]["covariance"] = lowerTriangle(rival->covariance->view());
  }
  return withOrigin(std::move(document), result.origin);
}

}  // namespace alidade
