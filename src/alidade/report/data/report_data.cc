// SPDX-License-Identifier: MIT
#include "alidade/report/data/report_data.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "alidade/core/diagnosis_order.h"
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
  for (std::size_t i = 0; i < offsets.size(); ++i) {
    const JsonNode offset = offsets.at(i);
    offset.requireSize(3);
    shape.offsets_m.emplace_back(offset.at(0).finite(), offset.at(1).finite(), offset.at(2).finite());
  }
  return shape;
}

std::vector<ReportedBoard> readBoards(const JsonNode& root) {
  const JsonNode spec = root["board"];
  const JsonNode shape = root["board_shape"];
  const auto readOne = [](const JsonNode& of, const JsonNode& shape_of) {
    ReportedBoard board{.target = of.made([&] { return parseBoardSpec(of.text()); })};
    board.shape = readShape(shape_of, board.target);
    return board;
  };
  if (!spec.isArray()) return {readOne(spec, shape)};
  std::vector<ReportedBoard> boards;
  shape.requireSize(spec.size());
  for (std::size_t i = 0; i < spec.size(); ++i) boards.push_back(readOne(spec.at(i), shape.at(i)));
  if (boards.empty()) spec.refuse("at least one board");
  return boards;
}

std::vector<ReportedView> readViews(const JsonNode& root, const std::vector<ReportedBoard>& boards) {
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

// Outliers are listed by image; where they were seen follows from the view's pose.
void addOutliers(const JsonNode& root, const ReportData& data, std::vector<ReportedView>& views) {
  std::map<std::pair<std::string, std::size_t>, ReportedView*> by_name;
  for (ReportedView& view : views) by_name[{view.image, view.board}] = &view;
  const JsonNode outliers = root["outliers"];
  for (std::size_t i = 0; i < outliers.size(); ++i) {
    const JsonNode node = outliers.at(i);
    const std::size_t board = readBoardIndex(node, data.boards);
    const auto view = by_name.find({node["image"].text(), board});
    if (view == by_name.end()) continue;  // of a view that was left out
    const ReportedBoard& on = data.boards[board];
    const int id = node["corner_id"].whole(0, on.target.numCorners() - 1);
    const Eigen::Vector2d error(node["dx"].finite(), node["dy"].finite());
    const Projection projected =
        data.camera.project(view->second->camera_from_board * pointOn(on.target, on.shape, id));
    if (!projected.ok()) continue;
    view->second->outliers.push_back({.id = id, .pixel = projected.pixel - error, .error_px = error});
  }
}

void addCoverage(const JsonNode& root, ReportData& data) {
  const JsonNode coverage = root["coverage"];
  const JsonNode grid = coverage["grid"];
  data.cells = {.columns = grid["columns"].whole(1, kMaxGridSide),
                .rows = grid["rows"].whole(1, kMaxGridSide)};
  const JsonNode counts = grid["num_corners"];
  counts.requireSize(static_cast<std::size_t>(data.cells.columns) *
                     static_cast<std::size_t>(data.cells.rows));
  data.cells.num_corners =
      counts.list([](const JsonNode& n) { return n.whole(-1, std::numeric_limits<int>::max()); });
  const JsonNode views = coverage["views"];
  views.requireSize(data.views.size());
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    const JsonNode view = views.at(v);
    const JsonNode tilt = view["tilt"];
    data.views[v].distance_m = view["distance_m"].finite();
    data.views[v].right_nearer_rad = tilt["right_nearer_rad"].number();
    data.views[v].lower_nearer_rad = tilt["lower_nearer_rad"].number();
  }
}

std::optional<ReportedAccuracy> readAccuracy(const JsonNode& node) {
  if (node.isNull()) return std::nullopt;
  ReportedAccuracy accuracy;
  const double distance = node["distance_m"].number();
  if (std::isfinite(distance)) accuracy.distance_m = distance;  // null: far points
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
  const JsonNode worst = node["worst_pixel"];
  worst.requireSize(2);
  accuracy.worst_pixel = {worst.at(0).finite(), worst.at(1).finite()};
  return accuracy;
}

std::vector<ReportedModel> readModels(const JsonNode& choice) {
  if (choice.isNull()) return {};
  return choice["candidates"].list([](const JsonNode& node) {
    return ReportedModel{.id = node["model"].text(),
                         .num_params = node["num_parameters"].whole(0, 1000),
                         .rms_px = node["rms_px"].number(),
                         .holdout_rms_px = node["holdout_rms_px"].number(),
                         .verdict = node["verdict"].text(),
                         .reason = node["reason"].text()};
  });
}

std::optional<ReportedNextView> readNextView(const JsonNode& node, const std::vector<ReportedBoard>& boards) {
  if (node.isNull()) return std::nullopt;
  ReportedNextView next{.board = readBoardIndex(node, boards),
                        .camera_from_board = readPose(node["camera_from_board"])};
  next.text = node["text"].text();
  next.distance_m = node["distance_m"].finite();
  const JsonNode tilt = node["tilt"];
  next.right_nearer_rad = tilt["right_nearer_rad"].number();
  next.lower_nearer_rad = tilt["lower_nearer_rad"].number();
  next.worst_now_px = node["worst_now_px"].number();
  next.worst_then_px = node["worst_then_px"].number();
  return next;
}

}  // namespace

std::size_t readBoardIndex(const JsonNode& node, const std::vector<ReportedBoard>& boards) {
  if (!node.has("board")) return 0;
  const JsonNode board = node["board"];
  const std::string spec = board.text();
  const auto at = std::ranges::find_if(boards, [&](const auto& b) { return b.target.spec() == spec; });
  if (at == boards.end()) board.refuse("one of the boards of this calibration");
  return static_cast<std::size_t>(at - boards.begin());
}

ReportedCorner readCorner(const JsonNode& node, const Board& board) {
  return {.id = node["id"].whole(0, board.numCorners() - 1),
          .pixel = {node["u"].finite(), node["v"].finite()},
          .error_px = {node["dx"].finite(), node["dy"].finite()}};
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

Eigen::Vector2d ReportedAccuracy::pixel(int column, int row, const ImageSize& size) const {
  return {column * (size.width - 1.0) / (columns - 1), row * (size.height - 1.0) / (rows - 1)};
}

double ReportedAccuracy::shareWithin(double tolerance_px) const {
  int num_within = 0;
  int num_with_ray = 0;
  for (const double error : error_px) {
    num_with_ray += std::isnan(error) ? 0 : 1;
    num_within += error <= tolerance_px ? 1 : 0;
  }
  return num_with_ray == 0 ? 0 : static_cast<double>(num_within) / num_with_ray;
}

bool ReportedAccuracy::hasBlindPixels() const {
  return std::ranges::any_of(error_px, [](double error) { return std::isnan(error); });
}

const char* ReportedAccuracy::wholeName() const {
  return hasBlindPixels() ? "the pixels with a ray" : "the image";
}

ReportData readReportData(const nlohmann::json& evidence, const std::string& file) {
  const JsonNode root(evidence, file);
  ReportData data{.camera = readCamera(root),
                  .size = readSize(root["image_size"]),
                  .verdict = readVerdict(root["verdict"]),
                  .tolerance_px = root["tolerance_px"].finite(),
                  .boards = readBoards(root)};
  data.views = readViews(root, data.boards);
  addOutliers(root, data, data.views);
  data.findings = readFindings(root["findings"]);
  sortDiagnoses(data.findings);
  data.accuracy = readAccuracy(root["accuracy"]);
  addCoverage(root, data);
  data.rms_px = root["rms_px"].number();
  data.holdout_rms_px = root["holdout_rms_px"].number();
  data.coordinate_sigma_px = root["coordinate_sigma_px"].number();
  constexpr int kMany = std::numeric_limits<int>::max();
  data.num_corners = root["num_corners"].whole(0, kMany);
  data.num_outliers = static_cast<int>(root["outliers"].size());
  const JsonNode images = root["images"];
  data.num_images_given = images["given"].whole(0, kMany);
  data.num_images_used = images["used"].whole(0, kMany);
  data.reasons = images["reasons"].list(textOf);
  data.notes = root["notes"].list(textOf);
  const JsonNode stds = root["parameter_std"];
  for (const std::string_view name : data.camera.parameterNames())
    data.parameter_std.push_back(stds[std::string(name).c_str()].number());
  data.covariance = readCovariance(root["covariance"], static_cast<int>(data.parameter_std.size()));
  data.models = readModels(root["model_choice"]);
  data.next_view = readNextView(root["next_view"], data.boards);
  data.created_by = root["created_by"].text();
  return data;
}

}  // namespace alidade
