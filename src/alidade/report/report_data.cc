// SPDX-License-Identifier: MIT
#include "alidade/report/report_data.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "alidade/core/error.h"
#include "alidade/target/board_spec.h"

namespace alidade {
namespace {

using nlohmann::json;

constexpr int kMaxImageSide = 1'000'000;
constexpr int kMaxGridSide = 2'000;

// A value of the document and where it stands. Places are put into words only for messages.
class Node {
 public:
  Node(const json& value, const std::string& file) : value_(&value), file_(&file) {}

  [[nodiscard]] Node operator[](const char* key) const {
    if (!value_->is_object()) refuse("an object");
    const auto found = value_->find(key);
    if (found == value_->end())
      throw inputError({.where = *file_ + ": " + (place().empty() ? "" : place() + ".") + key,
                        .found = "missing",
                        .expected = "the evidence of a calibration of one camera",
                        .next_step = "write it again with alidade calibrate --evidence"});
    return {*found, *this, key, 0};
  }
  [[nodiscard]] Node at(std::size_t i) const { return {(*value_)[i], *this, nullptr, i}; }
  [[nodiscard]] bool has(const char* key) const { return value_->is_object() && value_->contains(key); }
  [[nodiscard]] bool isNull() const { return value_->is_null(); }
  [[nodiscard]] bool isArray() const { return value_->is_array(); }

  /// NaN for null: JSON has no such number.
  [[nodiscard]] double number() const {
    if (value_->is_null()) return std::numeric_limits<double>::quiet_NaN();
    if (!value_->is_number()) refuse("a number");
    return value_->get<double>();
  }
  [[nodiscard]] double finite() const {
    const double value = number();
    if (!std::isfinite(value)) refuse("a number");
    return value;
  }
  [[nodiscard]] int whole(int least, int most) const {
    const double value = number();
    if (!(value >= least && value <= most) || value != std::floor(value))
      refuse(fmt::format("a whole number from {} to {}", least, most));
    return static_cast<int>(value);
  }
  [[nodiscard]] std::string text() const {
    if (!value_->is_string()) refuse("a text");
    return value_->get<std::string>();
  }
  [[nodiscard]] bool flag() const {
    if (!value_->is_boolean()) refuse("true or false");
    return value_->get<bool>();
  }
  [[nodiscard]] std::size_t size() const {
    if (!value_->is_array()) refuse("a list");
    return value_->size();
  }
  /// Refuses anything but a list of `count` elements.
  void requireSize(std::size_t count) const {
    if (size() != count) refuse(fmt::format("a list of {} elements", count));
  }
  template <class Read>
  [[nodiscard]] auto list(Read read) const {
    std::vector<decltype(read(*this))> values;
    const std::size_t count = size();
    values.reserve(count);
    for (std::size_t i = 0; i < count; ++i) values.push_back(read(at(i)));
    return values;
  }

  /// What `make` makes of the value; its complaint becomes one about this place.
  template <class Make>
  [[nodiscard]] auto made(Make make) const {
    try {
      return make();
    } catch (const Error& error) {
      const std::string complaint = error.what();
      throw inputError({.where = *file_ + ": " + place(),
                        .found = complaint.substr(0, complaint.find('\n')),
                        .next_step = "write it again with alidade calibrate --evidence"});
    }
  }
  [[noreturn]] void refuse(const std::string& expected) const {
    throw inputError({.where = *file_ + (place().empty() ? "" : ": " + place()),
                      .found = value_->is_structured() ? "a value of another kind" : value_->dump(),
                      .expected = expected,
                      .next_step = "write it again with alidade calibrate --evidence"});
  }

 private:
  Node(const json& value, const Node& parent, const char* key, std::size_t index)
      : value_(&value), file_(parent.file_), parent_(&parent), key_(key), index_(index) {}

  [[nodiscard]] std::string place() const {
    if (parent_ == nullptr) return "";
    const std::string before = parent_->place();
    if (key_ == nullptr) return fmt::format("{}[{}]", before, index_);
    return before.empty() ? key_ : before + "." + key_;
  }

  const json* value_;
  const std::string* file_;
  const Node* parent_ = nullptr;
  const char* key_ = nullptr;
  std::size_t index_ = 0;
};

std::string textOf(const Node& node) {
  return node.text();
}

ImageSize readSize(const Node& node) {
  const Node width = node["width"];
  const Node height = node["height"];
  return {.width = width.whole(1, kMaxImageSide), .height = height.whole(1, kMaxImageSide)};
}

SE3 readPose(const Node& node) {
  const Node quaternion = node["quaternion_xyzw"];
  const Node translation = node["translation_m"];
  quaternion.requireSize(4);
  translation.requireSize(3);
  const Eigen::Quaterniond q(quaternion.at(3).finite(), quaternion.at(0).finite(), quaternion.at(1).finite(),
                             quaternion.at(2).finite());
  return {quaternion.made([&] { return SO3::fromQuaternion(q); }),
          {translation.at(0).finite(), translation.at(1).finite(), translation.at(2).finite()}};
}

// The index of a board that has its SPEC stated, or of the only one.
std::size_t readBoardIndex(const Node& node, const std::vector<ReportedBoard>& boards) {
  if (!node.has("board")) return 0;
  const Node board = node["board"];
  const std::string spec = board.text();
  const auto at = std::ranges::find_if(boards, [&](const auto& b) { return b.target.spec() == spec; });
  if (at == boards.end()) board.refuse("one of the boards of this calibration");
  return static_cast<std::size_t>(at - boards.begin());
}

std::vector<ReportedBoard> readBoards(const Node& root) {
  const Node spec = root["board"];
  const Node shape = root["board_shape"];
  const auto readOne = [](const Node& of, const Node& shape_of) {
    return ReportedBoard{
        .target = of.made([&] { return parseBoardSpec(of.text()); }),
        .shape = {.bend_x_m = shape_of["bend_x_m"].finite(), .bend_y_m = shape_of["bend_y_m"].finite()}};
  };
  if (!spec.isArray()) return {readOne(spec, shape)};
  std::vector<ReportedBoard> boards;
  shape.requireSize(spec.size());
  for (std::size_t i = 0; i < spec.size(); ++i) boards.push_back(readOne(spec.at(i), shape.at(i)));
  if (boards.empty()) spec.refuse("at least one board");
  return boards;
}

ReportedCorner readCorner(const Node& node, const Board& board) {
  return {.id = node["id"].whole(0, board.numCorners() - 1),
          .pixel = {node["u"].finite(), node["v"].finite()},
          .error_px = {node["dx"].finite(), node["dy"].finite()}};
}

std::vector<ReportedView> readViews(const Node& root, const std::vector<ReportedBoard>& boards) {
  return root["views"].list([&](const Node& node) {
    ReportedView view{.image = node["image"].text(), .board = readBoardIndex(node, boards)};
    view.rms_px = node["rms_px"].finite();
    view.max_error_px = node["max_error_px"].finite();
    view.camera_from_board = readPose(node["camera_from_board"]);
    view.corners = node["corners"].list(
        [&](const Node& corner) { return readCorner(corner, boards[view.board].target); });
    return view;
  });
}

// Outliers are listed by image; where they were seen follows from the view's pose.
void addOutliers(const Node& root, const ReportData& data, std::vector<ReportedView>& views) {
  std::map<std::pair<std::string, std::size_t>, ReportedView*> by_name;
  for (ReportedView& view : views) by_name[{view.image, view.board}] = &view;
  const Node outliers = root["outliers"];
  for (std::size_t i = 0; i < outliers.size(); ++i) {
    const Node node = outliers.at(i);
    const std::size_t board = readBoardIndex(node, data.boards);
    const auto view = by_name.find({node["image"].text(), board});
    if (view == by_name.end()) continue;  // of a view that was left out
    const ReportedBoard& on = data.boards[board];
    const int id = node["corner_id"].whole(0, on.target.numCorners() - 1);
    const Eigen::Vector2d error(node["dx"].finite(), node["dy"].finite());
    const Projection projected = data.camera.project(view->second->camera_from_board *
                                                     onBentBoard(on.target, on.shape, on.target.corner(id)));
    if (!projected.ok()) continue;
    view->second->outliers.push_back({.id = id, .pixel = projected.pixel - error, .error_px = error});
  }
}

void addCoverage(const Node& root, ReportData& data) {
  const Node coverage = root["coverage"];
  const Node grid = coverage["grid"];
  data.cells = {.columns = grid["columns"].whole(1, kMaxGridSide),
                .rows = grid["rows"].whole(1, kMaxGridSide)};
  const Node counts = grid["num_corners"];
  counts.requireSize(static_cast<std::size_t>(data.cells.columns) *
                     static_cast<std::size_t>(data.cells.rows));
  data.cells.num_corners =
      counts.list([](const Node& n) { return n.whole(-1, std::numeric_limits<int>::max()); });
  const Node views = coverage["views"];
  views.requireSize(data.views.size());
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    const Node view = views.at(v);
    const Node tilt = view["tilt"];
    data.views[v].distance_m = view["distance_m"].finite();
    data.views[v].right_nearer_rad = tilt["right_nearer_rad"].number();
    data.views[v].lower_nearer_rad = tilt["lower_nearer_rad"].number();
  }
}

std::optional<ReportedAccuracy> readAccuracy(const Node& node) {
  if (node.isNull()) return std::nullopt;
  ReportedAccuracy accuracy;
  const double distance = node["distance_m"].number();
  if (std::isfinite(distance)) accuracy.distance_m = distance;  // null: far points
  accuracy.columns = node["columns"].whole(2, kMaxGridSide);
  accuracy.rows = node["rows"].whole(2, kMaxGridSide);
  const auto count = static_cast<std::size_t>(accuracy.columns) * static_cast<std::size_t>(accuracy.rows);
  const Node errors = node["error_px"];
  const Node covered = node["is_covered"];
  errors.requireSize(count);
  covered.requireSize(count);
  accuracy.error_px = errors.list([](const Node& n) { return n.number(); });
  accuracy.is_covered = covered.list([](const Node& n) { return n.flag(); });
  accuracy.covered_px = node["covered_px"].number();
  accuracy.covered_share = node["covered_share"].number();
  accuracy.worst_px = node["worst_px"].number();
  const Node worst = node["worst_pixel"];
  worst.requireSize(2);
  accuracy.worst_pixel = {worst.at(0).finite(), worst.at(1).finite()};
  return accuracy;
}

std::vector<Diagnosis> readFindings(const Node& node) {
  return node.list([](const Node& finding) {
    const Node severity = finding["severity"];
    const std::string name = severity.text();
    Diagnosis diagnosis{.id = finding["id"].text(), .cause = finding["cause"].text()};
    diagnosis.evidence = finding["evidence"].text();
    diagnosis.next_step = finding["next_step"].text();
    diagnosis.effect_px = finding["effect_px"].number();
    for (const Severity known : {Severity::kPass, Severity::kNote, Severity::kWarning, Severity::kFailure}) {
      if (severityName(known) != name) continue;
      diagnosis.severity = known;
      return diagnosis;
    }
    severity.refuse("pass, note, warning or failure");
  });
}

std::vector<ReportedModel> readModels(const Node& choice) {
  if (choice.isNull()) return {};
  return choice["candidates"].list([](const Node& node) {
    return ReportedModel{.id = node["model"].text(),
                         .num_params = node["num_parameters"].whole(0, 1000),
                         .rms_px = node["rms_px"].number(),
                         .holdout_rms_px = node["holdout_rms_px"].number(),
                         .verdict = node["verdict"].text(),
                         .reason = node["reason"].text()};
  });
}

std::optional<ReportedNextView> readNextView(const Node& node, const std::vector<ReportedBoard>& boards) {
  if (node.isNull()) return std::nullopt;
  ReportedNextView next{.board = readBoardIndex(node, boards),
                        .camera_from_board = readPose(node["camera_from_board"])};
  next.text = node["text"].text();
  next.distance_m = node["distance_m"].finite();
  const Node tilt = node["tilt"];
  next.right_nearer_rad = tilt["right_nearer_rad"].number();
  next.lower_nearer_rad = tilt["lower_nearer_rad"].number();
  next.worst_now_px = node["worst_now_px"].number();
  next.worst_then_px = node["worst_then_px"].number();
  return next;
}

// The lower triangle row by row.
std::optional<Eigen::MatrixXd> readCovariance(const Node& node, int n) {
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

AnyCamera readCamera(const Node& root) {
  const Node of_model = root["model"];
  const std::string model = of_model.text();
  const Node values = root["parameters"];
  std::vector<double> params;
  for (const std::string_view name : of_model.made([&] { return parameterNames(model); }))
    params.push_back(values[std::string(name).c_str()].finite());
  return values.made([&] { return AnyCamera::make(model, params); });
}

Verdict readVerdict(const Node& node) {
  const auto verdict = verdictOf(node.text());
  if (!verdict) node.refuse("trustworthy, usable_with_reservations or rejected");
  return *verdict;
}

}  // namespace

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

ReportData readReportData(const nlohmann::json& evidence, const std::string& file) {
  const Node root(evidence, file);
  ReportData data{.camera = readCamera(root),
                  .size = readSize(root["image_size"]),
                  .verdict = readVerdict(root["verdict"]),
                  .tolerance_px = root["tolerance_px"].finite(),
                  .boards = readBoards(root)};
  data.views = readViews(root, data.boards);
  addOutliers(root, data, data.views);
  data.findings = readFindings(root["findings"]);
  data.accuracy = readAccuracy(root["accuracy"]);
  addCoverage(root, data);
  data.rms_px = root["rms_px"].number();
  data.holdout_rms_px = root["holdout_rms_px"].number();
  data.coordinate_sigma_px = root["coordinate_sigma_px"].number();
  constexpr int kMany = std::numeric_limits<int>::max();
  data.num_corners = root["num_corners"].whole(0, kMany);
  data.num_outliers = static_cast<int>(root["outliers"].size());
  const Node images = root["images"];
  data.num_images_given = images["given"].whole(0, kMany);
  data.num_images_used = images["used"].whole(0, kMany);
  data.reasons = images["reasons"].list(textOf);
  data.notes = root["notes"].list(textOf);
  const Node stds = root["parameter_std"];
  for (const std::string_view name : data.camera.parameterNames())
    data.parameter_std.push_back(stds[std::string(name).c_str()].number());
  data.covariance = readCovariance(root["covariance"], static_cast<int>(data.parameter_std.size()));
  data.models = readModels(root["model_choice"]);
  data.next_view = readNextView(root["next_view"], data.boards);
  data.created_by = root["created_by"].text();
  return data;
}

}  // namespace alidade
