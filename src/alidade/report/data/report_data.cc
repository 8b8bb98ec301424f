// SPDX-License-Identifier: MIT
#include "alidade/report/data/report_data.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "alidade/core/diagnosis.h"
#include "alidade/core/error.h"
#include "alidade/report/data/json_node.h"
#include "alidade/target/board_spec.h"

namespace alidade {
namespace {

using nlohmann::json;

constexpr int kMaxGridSide = 2'000;

BoardShape readShape(const JsonNode& node, const Board& target) {
  BoardShape shape{.bend_x_m = node["bend_x_m"].finite(), .bend_y_m = node["bend_y_m"].finite()};
  if (!node.has("offsets_m")) return shape;
  const JsonNode offsets = node["offsets_m"];
  offsets.requireSize(static_cast<std::size_t>(target.numCorners()));
  shape.offsets_m = offsets.list(readVector<3>);
  return shape;
}

std::vector<FitBoard> readBoards(const JsonNode& root) {
  const JsonNode spec = root["board"];
  const JsonNode shape = root["board_shape"];
  const auto readOne = [](const JsonNode& of, const JsonNode& shape_of) {
    FitBoard board{.target = of.made([&] { return parseBoardSpec(of.text()); })};
    board.shape = readShape(shape_of, board.target);
    if (shape_of.has("flex_std_m")) board.flex.std_m = shape_of["flex_std_m"].finite();
    return board;
  };
  if (!spec.isArray()) return {readOne(spec, shape)};
  if (spec.size() == 0) spec.refuse("at least one board");
  shape.requireSize(spec.size());
  std::vector<FitBoard> boards;
  for (std::size_t i = 0; i < spec.size(); ++i) boards.push_back(readOne(spec.at(i), shape.at(i)));
  return boards;
}

std::vector<ReportedView> readViews(const JsonNode& root, const std::vector<FitBoard>& boards) {
  return root["views"].list([&](const JsonNode& node) {
    ReportedView view{.image = node["image"].text(), .board = readBoardIndex(node, boards)};
    view.rms_px = node["rms_px"].finite();
    view.max_error_px = node["max_error_px"].finite();
    view.camera_from_board = readPose(node["camera_from_board"]);
    view.corners = node["corners"].list(
        [&](const JsonNode& corner) { return readCorner(corner, boards[view.board].target); });
    return view;
  });
}

// Outliers are listed by image. Where their observed pixels are not stated, they follow from the view's pose.
void addOutliers(const JsonNode& root, const ReportData& data, std::vector<ReportedView>& views) {
  std::map<std::pair<std::string, std::size_t>, ReportedView*> by_name;
  for (ReportedView& view : views) by_name[{view.image, view.board}] = &view;
  const JsonNode outliers = root["outliers"];
  for (std::size_t i = 0; i < outliers.size(); ++i) {
    const JsonNode node = outliers.at(i);
    const std::size_t board = readBoardIndex(node, data.boards);
    const auto view = by_name.find({node["image"].text(), board});
    if (view == by_name.end()) continue;  // belongs to a view that was left out
    const FitBoard& on = data.boards[board];
    const int id = node["corner_id"].whole(0, on.target.numCorners() - 1);
    const Eigen::Vector2d error(node["dx"].finite(), node["dy"].finite());
    if (node.has("u") && node.has("v")) {
      const Eigen::Vector2d pixel(node["u"].finite(), node["v"].finite());
      view->second->outliers.push_back({.id = id, .pixel = pixel, .error_px = error});
      continue;
    }
    const Projection projected =
        data.camera.projectPoint(view->second->camera_from_board * pointOn(on.target, on.shape, id));
    if (!projected.ok()) continue;
    view->second->outliers.push_back({.id = id, .pixel = projected.pixel - error, .error_px = error});
  }
}

void addSighting(const JsonNode& node, ReportedView& view) {
  view.distance_m = node["distance_m"].finite();
  const JsonNode tilt = node["tilt"];
  view.tilt = {.right_rad = tilt["right_nearer_rad"].number(),
               .lower_rad = tilt["lower_nearer_rad"].number()};
}

void addCoverage(const JsonNode& root, CalibrationEvidence& data) {
  const JsonNode coverage = root["coverage"];
  const JsonNode grid = coverage["grid"];
  data.coverage.columns = grid["columns"].whole(1, kMaxGridSide);
  data.coverage.rows = grid["rows"].whole(1, kMaxGridSide);
  const JsonNode counts = grid["num_corners"];
  counts.requireSize(static_cast<std::size_t>(data.coverage.columns) *
                     static_cast<std::size_t>(data.coverage.rows));
  data.coverage.num_corners =
      counts.list([](const JsonNode& n) { return n.whole(-1, std::numeric_limits<int>::max()); });
  const JsonNode views = coverage["views"];
  views.requireSize(data.views.size());
  for (std::size_t v = 0; v < data.views.size(); ++v) addSighting(views.at(v), data.views[v]);
}

std::vector<ModelCandidate> readModels(const JsonNode& choice) {
  if (choice.isNull()) return {};
  return choice["candidates"].list([](const JsonNode& node) {
    return ModelCandidate{.id = node["model"].text(),
                          .num_params = node["num_parameters"].whole(0, 1000),
                          .rms_px = node["rms_px"].number(),
                          .holdout_rms_px = node["holdout_rms_px"].number(),
                          .verdict = node["verdict"].text(),
                          .reason = node["reason"].text()};
  });
}

void addNextView(const JsonNode& node, CalibrationEvidence& data) {
  if (node.isNull()) return;
  data.next_view = {.board = readBoardIndex(node, data.boards),
                    .camera_from_board = readPose(node["camera_from_board"])};
  data.next_text = node["text"].text();
  addSighting(node, *data.next_view);
}

std::vector<std::string> readSettings(const json& evidence) {
  std::vector<std::string> settings;
  const json given = evidence.value("settings", json::object());
  for (const auto& [name, values] : given.items()) {
    std::string line = "--" + name;
    for (const json& value : values)
      line += " " + (value.is_string() ? validUtf8(value.get<std::string>()) : value.dump());
    settings.push_back(line);
  }
  return settings;
}

}  // namespace

json withOrigin(json document, const RunOrigin& origin) {
  document["created_by"] = origin.created_by;
  document["origin"] = {{"inputs", origin.inputs},
                        {"name", origin.camera.name},
                        {"serial", origin.camera.serial},
                        {"date", origin.date}};
  return document;
}

RunOrigin readOrigin(const JsonNode& root) {
  RunOrigin origin{.created_by = root["created_by"].text()};
  if (!root.has("origin")) return origin;
  const JsonNode node = root["origin"];
  origin.inputs = node["inputs"].list(textOf);
  origin.camera = {.name = node["name"].text(), .serial = node["serial"].text(), .lens = {}};
  origin.date = node["date"].text();
  return origin;
}

std::size_t readBoardIndex(const JsonNode& node, const std::vector<FitBoard>& boards) {
  if (!node.has("board")) return 0;
  const JsonNode board = node["board"];
  const std::string spec = board.text();
  const auto at = std::ranges::find_if(boards, [&](const auto& b) { return b.target.spec() == spec; });
  if (at == boards.end()) board.refuse("one of the boards of this calibration");
  return static_cast<std::size_t>(at - boards.begin());
}

CornerError readCorner(const JsonNode& node, const Board& board) {
  return {.id = node["id"].whole(0, board.numCorners() - 1),
          .pixel = {node["u"].finite(), node["v"].finite()},
          .error_px = {node["dx"].finite(), node["dy"].finite()}};
}

std::optional<Accuracy> readAccuracy(const JsonNode& node) {
  if (node.isNull()) return std::nullopt;
  Accuracy accuracy;
  const double distance = node["distance_m"].number();
  if (std::isfinite(distance)) accuracy.distance_m = distance;  // null: distant points
  accuracy.columns = node["columns"].whole(2, kMaxGridSide);
  accuracy.rows = node["rows"].whole(2, kMaxGridSide);
  const auto count = static_cast<std::size_t>(accuracy.columns) * static_cast<std::size_t>(accuracy.rows);
  const JsonNode errors = node["error_px"];
  const JsonNode covered = node["is_covered"];
  errors.requireSize(count);
  covered.requireSize(count);
  accuracy.error_px = errors.list([](const JsonNode& n) { return n.number(); });
  accuracy.is_covered = covered.list([](const JsonNode& n) { return n.flag(); });
  accuracy.covered_px = node["covered_px"].number();
  accuracy.covered_share = node["covered_share"].number();
  accuracy.worst_px = node["worst_px"].number();
  accuracy.worst_pixel = readVector<2>(node["worst_pixel"]);
  return accuracy;
}

std::optional<Eigen::MatrixXd> readCovariance(const JsonNode& node, int n) {
  if (node.isNull()) return std::nullopt;
  node.requireSize(static_cast<std::size_t>(n * (n + 1) / 2));
  Eigen::MatrixXd covariance(n, n);
  std::size_t at = 0;
  for (int row = 0; row < n; ++row) {
    for (int column = 0; column <= row; ++column)
      covariance(row, column) = covariance(column, row) = node.at(at++).number();
  }
  return covariance;
}

std::vector<CornerError> allCorners(const ReportData& data) {
  std::vector<CornerError> corners;
  for (const ReportedView& view : data.views)
    corners.insert(corners.end(), view.corners.begin(), view.corners.end());
  return corners;
}

bool hasBlindPixels(const Accuracy& accuracy) {
  return std::ranges::any_of(accuracy.error_px, [](double error) { return std::isnan(error); });
}

const char* wholeName(const Accuracy& accuracy) {
  return hasBlindPixels(accuracy) ? "the pixels with a ray" : "the image";
}

CalibrationEvidence readCalibration(const nlohmann::json& evidence, const std::string& file) {
  const JsonNode root(evidence, file);
  CalibrationEvidence data{ReportData{.camera = readCamera(root), .size = readSize(root["image_size"])}};
  data.verdict = readVerdict(root["verdict"]);
  data.tolerance_px = root["tolerance_px"].finite();
  data.boards = readBoards(root);
  data.views = readViews(root, data.boards);
  addOutliers(root, data, data.views);
  data.findings = readFindings(root["findings"]);
  data.accuracy = readAccuracy(root["accuracy"]);
  addCoverage(root, data);
  data.rms_px = root["rms_px"].number();
  data.holdout_rms_px = root["holdout_rms_px"].number();
  data.coordinate_sigma_px = root["coordinate_sigma_px"].number();
  constexpr int kMany = std::numeric_limits<int>::max();
  data.num_outliers = static_cast<int>(root["outliers"].size());
  const JsonNode images = root["images"];
  data.num_images_given = images["given"].whole(0, kMany);
  data.num_images_used = images["used"].whole(0, kMany);
  data.reasons = images["reasons"].list(textOf);
  data.notes = root["notes"].list(textOf);
  data.settings = readSettings(evidence);
  const JsonNode stds = root["parameter_std"];
  for (const std::string_view name : data.camera.parameterNames())
    data.parameter_std.push_back(stds[std::string(name).c_str()].number());
  if (!data.camera.pupil().isFixed()) {
    const JsonNode pupil = root["entrance_pupil"];
    const JsonNode of_pupil = pupil["std"];
    if (of_pupil.size() > EntrancePupil::kSize) of_pupil.refuse("at most two numbers");
    data.pupil_std_m = of_pupil.list([](const JsonNode& std) { return std.number(); });
  }
  data.covariance = readCovariance(root["covariance"], static_cast<int>(data.parameter_std.size()));
  data.models = readModels(root["model_choice"]);
  addNextView(root["next_view"], data);
  data.origin = readOrigin(root);
  return data;
}

}  // namespace alidade
