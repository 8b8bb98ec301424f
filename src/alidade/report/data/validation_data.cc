// SPDX-License-Identifier: MIT
#include "alidade/report/data/validation_data.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <nlohmann/json.hpp>

#include "alidade/calibrate/uncertainty/accuracy.h"
#include "alidade/camera/projection_uncertainty.h"
#include "alidade/report/data/json_node.h"
#include "alidade/target/board_spec.h"

namespace alidade {
namespace {

constexpr int kManyCorners = std::numeric_limits<int>::max();

std::string textOrNone(const JsonNode& node) {
  return node.isNull() ? "" : node.text();
}

// The message of an error ends in what to do.
Diagnosis diagnosisFrom(Severity severity, const std::string& id, const std::string& message) {
  constexpr std::string_view kNext = "\n  next: ";
  const std::size_t end = message.find(kNext);
  Diagnosis check{.severity = severity, .id = id, .cause = message.substr(0, end)};
  if (end != std::string::npos) check.next_step = message.substr(end + kNext.size());
  for (std::string* const text : {&check.cause, &check.next_step}) std::ranges::replace(*text, '\n', ' ');
  return check;
}

Diagnosis readCheck(const JsonNode& node) {
  return diagnosisFrom(readSeverity(node["status"]), node["id"].text(), node["message"].text());
}

std::vector<double> readStds(const JsonNode& node, const AnyCamera& camera) {
  std::vector<double> stds;
  for (const std::string_view name : camera.parameterNames())
    stds.push_back(node[std::string(name).c_str()].number());
  return stds;
}

// The 95 % error of distant points that the covariance tells.
ReportedAccuracy accuracyByCovariance(const AnyCamera& camera, const ImageSize& size,
                                      const Eigen::MatrixXd& covariance) {
  const ProjectionUncertainty projection(camera, size, std::numeric_limits<double>::infinity());
  ReportedAccuracy accuracy{
      .is_by_covariance = true, .columns = projection.columns(), .rows = projection.rows()};
  accuracy.worst_px = 0;
  for (std::size_t i = 0; i < projection.pixels().size(); ++i) {
    const auto index = static_cast<int>(i);
    double error_px = std::numeric_limits<double>::quiet_NaN();
    if (projection.hasRay(index)) {
      const auto A = projection.jacobian(index);
      error_px = radius95(Eigen::Matrix2d(A * covariance * A.transpose()));
    }
    accuracy.error_px.push_back(error_px);
    if (!(error_px > accuracy.worst_px)) continue;
    accuracy.worst_px = error_px;
    accuracy.worst_pixel = projection.pixels()[i];
  }
  accuracy.is_covered.resize(accuracy.error_px.size());
  return accuracy;
}

ReportedFreed readFreed(const JsonNode& node) {
  ReportedFreed freed{.camera = readCamera(node)};
  freed.parameter_std = readStds(node["parameter_std"], freed.camera);
  freed.covariance = readCovariance(node["covariance"], static_cast<int>(freed.parameter_std.size()));
  return freed;
}

// Adds the views to the figures' data.
ReportedHeldOut readHeldOut(const JsonNode& node, ReportData& data) {
  ReportedHeldOut tested{.num_views_given = node["num_views_given"].whole(0, kManyCorners),
                         .num_corners = node["num_corners"].whole(0, kManyCorners),
                         .rms_px = node["rms_px"].number(),
                         .noise_rms_px = node["noise_rms_px"].number(),
                         .fixed_rms_px = node["fixed_rms_px"].number(),
                         .freed_rms_px = node["freed_rms_px"].number(),
                         .p95_px = node["p95_px"].number(),
                         .covered_share = node["covered_share"].number()};
  const JsonNode freed = node["freed"];
  if (!freed.isNull()) tested.freed = readFreed(freed);
  data.boards = node["boards"].list([](const JsonNode& board) {
    return ReportedBoard{.target = board.made([&] { return parseBoardSpec(board.text()); })};
  });
  const JsonNode views = node["views"];
  for (std::size_t v = 0; v < views.size(); ++v) {
    const JsonNode at = views.at(v);
    ReportedView view{.image = at["image"].text(), .board = readBoardIndex(at, data.boards)};
    const JsonNode corners = at["corners"];
    if (corners.size() == 0) {
      tested.untested.push_back(view.image);
      continue;
    }
    view.rms_px = at["rms_px"].finite();
    view.camera_from_board = readPose(at["camera_from_board"]);
    view.max_error_px = at["max_error_px"].finite();
    view.corners = corners.list(
        [&](const JsonNode& corner) { return readCorner(corner, data.boards[view.board].target); });
    tested.view_fixed_px.push_back(at["fixed_rms_px"].number());
    tested.view_freed_px.push_back(at["freed_rms_px"].number());
    data.views.push_back(std::move(view));
  }
  data.rms_px = tested.rms_px;
  data.coordinate_sigma_px = node["noise_sigma_px"].number();
  data.num_corners = tested.num_corners;
  data.num_images_given = tested.num_views_given;
  return tested;
}

ReportedFootageCheck readFootageCheck(const JsonNode& node) {
  ReportedFootageCheck check{.verdict = node["verdict"].text(),
                             .explanation = textOrNone(node["explanation"]),
                             .num_frames = node["num_frames"].whole(0, kManyCorners),
                             .num_points = node["num_points"].whole(0, kManyCorners),
                             .num_pixels = node["num_pixels"].whole(0, kManyCorners),
                             .holdout_rms_px = node["holdout_rms_px"].number(),
                             .noise_px = node["noise_px"].number(),
                             .columns = node["cell_columns"].whole(1, 1000),
                             .rows = node["cell_rows"].whole(1, 1000)};
  check.changes = node["changes"].list([](const JsonNode& change) {
    return ReportedChange{.id = change["id"].text(),
                          .text = change["text"].text(),
                          .cost_drop = change["cost_drop"].number(),
                          .effect_px = change["effect_px"].number(),
                          .sure_px = change["sure_px"].number(),
                          .blind_px = change["blind_px"].number()};
  });
  check.cells = node["cells"].list([](const JsonNode& cell) {
    return ReportedFootageCell{.num_pixels = cell["num_pixels"].whole(0, kManyCorners),
                               .rms_px = cell["rms_px"].number(),
                               .mean_px = {cell["dx"].number(), cell["dy"].number()}};
  });
  return check;
}

ReportedFootage readFootage(const JsonNode& node) {
  ReportedFootage footage{.verdict = node["verdict"].text(),
                          .size = readSize(node["image_size"]),
                          .tolerance_px = node["tolerance_px"].finite()};
  const JsonNode check = node["check"];
  if (!check.isNull()) footage.checks.push_back(readFootageCheck(check));
  const JsonNode edits = node["edits"];
  for (std::size_t i = 0; i < edits.size(); ++i) {
    footage.checks.push_back(readFootageCheck(edits.at(i)["check"]));
    footage.checks.back().edit = edits.at(i)["flags"].text();
  }
  return footage;
}

ReportedCameraJudgement readJudgement(const JsonNode& node, double tolerance_px) {
  ReportedCameraJudgement judgement{.name = node["name"].text(),
                                    .model = textOrNone(node["model"]),
                                    .checks = node["checks"].list(readCheck)};
  const JsonNode stated = node["calibration"];
  if (!stated.isNull()) {
    judgement.stated = ReportedStatement{.verdict = readVerdict(stated["verdict"]),
                                         .accuracy_px = stated["accuracy_px"].number(),
                                         .covered_share = stated["covered_share"].number()};
  }
  if (const JsonNode footage = node["footage"]; !footage.isNull()) judgement.footage = readFootage(footage);
  const JsonNode size = node["image_size"];
  if (judgement.model.empty() || size.isNull()) return judgement;
  ReportData data{.camera = readCamera(node), .size = readSize(size), .tolerance_px = tolerance_px};
  const std::size_t count = data.camera.parameters().size();
  data.parameter_std.assign(count, std::numeric_limits<double>::quiet_NaN());
  if (!stated.isNull()) {
    const JsonNode stds = stated["parameter_std"];
    if (!stds.isNull() && stds.size() == count)
      data.parameter_std = stds.list([](const JsonNode& std) { return std.number(); });
    const JsonNode covariance = stated["covariance"];
    if (!covariance.isNull() && covariance.size() == count * (count + 1) / 2)
      data.covariance = readCovariance(covariance, static_cast<int>(count));
  }
  if (data.covariance && data.covariance->allFinite())
    data.accuracy = accuracyByCovariance(data.camera, data.size, *data.covariance);
  const JsonNode held_out = node["held_out"];
  if (!held_out.isNull()) judgement.held_out = readHeldOut(held_out, data);
  judgement.data = std::move(data);
  return judgement;
}

}  // namespace

std::size_t ReportedValidation::count(Severity status) const {
  return static_cast<std::size_t>(std::ranges::count(files, status, &ReportedFile::status));
}

ReportedValidation readValidation(const nlohmann::json& document) {
  const std::string where = "the result of validate";
  const JsonNode root(document, where);
  ReportedValidation validation{.is_strict = root["strict"].flag(),
                                .tolerance_px = root["tolerance_px"].finite(),
                                .created_by = root["created_by"].text()};
  validation.other_files = root["other_files"].list(textOf);
  validation.files = root["files"].list([&](const JsonNode& node) {
    ReportedFile file{.name = node["file"].text(),
                      .status = readSeverity(node["status"]),
                      .format = textOrNone(node["format"])};
    const std::string error = textOrNone(node["error"]);
    if (!error.empty()) file.error = diagnosisFrom(Severity::kFailure, "unreadable", error);
    file.cameras = node["cameras"].list(
        [&](const JsonNode& camera) { return readJudgement(camera, validation.tolerance_px); });
    file.rig_checks = node["rig_checks"].list(readCheck);
    return file;
  });
  std::size_t num_views = 0;
  for (ReportedFile& file : validation.files) {
    for (ReportedCameraJudgement& camera : file.cameras) {
      if (!camera.data) continue;
      camera.data->first_view = num_views;
      num_views += camera.data->views.size();
    }
  }
  const JsonNode against = root["against"];
  if (!against.isNull()) {
    const AnyCamera camera = readCamera(against);
    validation.rival = RivalCamera{
        .name = against["file"].text(), .camera = camera, .size = readSize(against["image_size"])};
    const auto covariance =
        readCovariance(against["covariance"], static_cast<int>(camera.parameters().size()));
    if (covariance) validation.rival->covariance = *covariance;
  }
  return validation;
}

}  // namespace alidade
