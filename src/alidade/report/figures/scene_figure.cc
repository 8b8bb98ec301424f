// SPDX-License-Identifier: MIT
#include "alidade/report/figures/scene_figure.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "alidade/core/degrees.h"
#include "alidade/core/number_text.h"
#include "alidade/print/ink_of_board.h"

namespace alidade {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kYawDegrees = -38;
constexpr double kPitchDegrees = 24;
const Vector2d kSceneMiddle(220, 156);
const Vector2d kSceneSides(360, 250);  // room for the scene in the drawing

struct SceneShape {
  std::string attributes;
  std::vector<Vector3d> points;
  bool is_closed = false;
  std::string words = {};  // instead of a line
};

// The visible part of the scene, and its scale.
struct SceneView {
  Eigen::Matrix3d rotation;
  Vector3d middle;
  double scale = 1;

  [[nodiscard]] Vector3d turned(const Vector3d& point) const { return rotation * (point - middle); }
  [[nodiscard]] Vector2d at(const Vector3d& point) const {
    return kSceneMiddle + scale * turned(point).head<2>();
  }
  [[nodiscard]] double depth(const SceneShape& shape) const {
    double sum = 0;
    for (const Vector3d& point : shape.points) sum += turned(point).z();
    return sum / static_cast<double>(shape.points.size());
  }
};

std::vector<Vector3d> outlineOf(const Board& board, const SE3& camera_from_board) {
  const Eigen::AlignedBox2d box = inkOf(board).extent;
  std::vector<Vector3d> points;
  for (const Vector2d& corner :
       {box.min(), Vector2d(box.max().x(), box.min().y()), box.max(), Vector2d(box.min().x(), box.max().y())})
    points.push_back(camera_from_board * Vector3d(corner.x(), corner.y(), 0));
  return points;
}

// A camera as a pyramid with the image as its base, and its name.
void addCamera(const SceneCamera& camera, double length, std::vector<SceneShape>& shapes) {
  std::vector<Vector3d> base;
  const double right = camera.size.width - 1;
  const double low = camera.size.height - 1;
  const Vector3d eye = camera.scene_from_camera.translation;
  const Vector2d middle(0.5 * right, 0.5 * low);
  for (const Vector2d& corner :
       {Vector2d(0, 0), Vector2d(right, 0), Vector2d(right, low), Vector2d(0, low)}) {
    // Dark corners of a fisheye have no ray; the nearest pixel with one is used.
    for (double share = 1; share > 0; share -= 0.05) {
      const auto ray = camera.camera->unproject(middle + share * (corner - middle));
      if (!ray) continue;
      base.push_back(camera.scene_from_camera * Vector3d(length * *ray));
      break;
    }
  }
  for (const Vector3d& corner : base)
    shapes.push_back({.attributes = "class=\"pyramid\"", .points = {eye, corner}});
  if (base.size() == 4)
    shapes.push_back({.attributes = "class=\"pyramid\"", .points = base, .is_closed = true});
  if (!camera.name.empty())
    shapes.push_back({.attributes = "class=\"halo strong\"",
                      .points = {eye - Vector3d(0, 0.35 * length, 0)},
                      .words = camera.name});
}

// The optical axis, with marks at round distances.
void addAxis(double farthest_m, std::vector<SceneShape>& shapes) {
  const std::vector<double> marks = roundTicks(0, farthest_m, 4);
  if (marks.empty()) return;
  shapes.push_back(
      {.attributes = "class=\"sight\"", .points = {Vector3d::Zero(), Vector3d(0, 0, marks.back())}});
  const double half = 0.012 * farthest_m;
  for (const double z : marks) {
    if (z == 0) continue;
    shapes.push_back(
        {.attributes = "class=\"sight\"", .points = {Vector3d(0, -half, z), Vector3d(0, half, z)}});
    shapes.push_back({.attributes = "class=\"tick halo\"",
                      .points = {Vector3d(0, 3.2 * half, z)},
                      .words = fmt::format("{:g} m", z)});
  }
}

std::string pointsText(const std::vector<Vector3d>& points) {
  std::string text;
  for (const Vector3d& point : points)
    text += fmt::format("{}{:.4g} {:.4g} {:.4g}", text.empty() ? "" : " ", point.x(), point.y(), point.z());
  return text;
}

void addShape(const SceneShape& shape, const SceneView& view, FigureCanvas& canvas) {
  const std::string attributes =
      fmt::format("{} data-points=\"{}\"", shape.attributes, pointsText(shape.points));
  if (!shape.words.empty())
    return canvas.addText(view.at(shape.points[0]), shape.words, "middle", attributes);
  std::vector<Vector2d> points;
  for (const Vector3d& point : shape.points) points.push_back(view.at(point));
  canvas.addPath(pathThrough(points, shape.is_closed), attributes);
}

SceneView viewOf(const std::vector<SceneShape>& shapes) {
  Eigen::AlignedBox3d box(Vector3d::Zero());
  for (const SceneShape& shape : shapes)
    for (const Vector3d& point : shape.points) box.extend(point);
  SceneView view{.rotation = (Eigen::AngleAxisd(kPitchDegrees * kRadPerDeg, Vector3d::UnitX()) *
                              Eigen::AngleAxisd(kYawDegrees * kRadPerDeg, Vector3d::UnitY()))
                                 .toRotationMatrix(),
                 .middle = box.center()};
  Eigen::AlignedBox2d drawn;
  for (const SceneShape& shape : shapes)
    for (const Vector3d& point : shape.points) drawn.extend(view.turned(point).head<2>());
  view.middle += view.rotation.transpose() * Vector3d(drawn.center().x(), drawn.center().y(), 0);
  const Vector2d sizes = drawn.sizes();
  if (sizes.minCoeff() > 0) view.scale = kSceneSides.cwiseQuotient(sizes).minCoeff();
  return view;
}

}  // namespace

Figure sceneFigure(const SceneContent& content) {
  std::vector<SceneShape> shapes;
  double farthest = 0;
  for (const SceneBoard& board : content.boards) {
    shapes.push_back(
        {.attributes = board.is_next ? "class=\"board next\""
                       : board.view
                           ? fmt::format("class=\"board\" data-view=\"{}\"", *board.view)
                           : fmt::format("class=\"board\" data-tell=\"{}\"", escapedMarkup(board.words)),
         .points = outlineOf(*board.target, board.scene_from_board),
         .is_closed = true});
    if (board.is_next) continue;
    for (const Vector3d& point : shapes.back().points) farthest = std::max(farthest, point.norm());
  }
  if (!(farthest > 0)) farthest = 1;
  std::vector<SceneShape> fixed;
  for (const SceneCamera& camera : content.cameras) addCamera(camera, content.camera_share * farthest, fixed);
  addAxis(farthest, fixed);
  std::vector<SceneShape> all = shapes;
  all.insert(all.end(), fixed.begin(), fixed.end());
  const SceneView view = viewOf(all);
  // Far shapes first, so that near ones cover them.
  std::ranges::stable_sort(
      shapes, [&](const SceneShape& a, const SceneShape& b) { return view.depth(a) > view.depth(b); });
  FigureCanvas canvas(316);
  canvas.addRect({0, 0}, {FigureCanvas::kWidth, 312}, "class=\"paper\" rx=\"6\"");
  canvas.open("class=\"boards\"");
  for (const SceneShape& shape : shapes) addShape(shape, view, canvas);
  canvas.close();
  for (const SceneShape& shape : fixed) addShape(shape, view, canvas);
  Legend legend = {{"board", "board"}, {"line pyramid", "camera"}};
  if (std::ranges::any_of(content.boards, &SceneBoard::is_next))
    legend.emplace_back("board next", "suggested next view");
  canvas.addLegend({8, 320}, legend);
  Figure figure{.id = "scene", .title = content.title, .reading = content.reading};
  figure.alt = fmt::format("{} boards and {} in space, boards up to {} m away.", content.boards.size(),
                           counted(content.cameras.size(), "camera"), shortNumber(farthest));
  return canvas.drawn(
      std::move(figure),
      fmt::format(
          "id=\"scene-drawing\" tabindex=\"0\" data-yaw=\"{}\" data-pitch=\"{}\" data-scale=\"{:.6g}\" "
          "data-middle=\"{}\" data-at=\"{} {}\"",
          kYawDegrees, kPitchDegrees, view.scale, pointsText({view.middle}), kSceneMiddle.x(),
          kSceneMiddle.y()));
}

Figure sceneFigure(const CalibrationEvidence& data) {
  SceneContent content{.title = "Boards and camera in space", .reading = {}};
  content.reading =
      "Drag the drawing, or select it and use the arrow keys, to turn it; the boards should fill the space "
      "that the camera sees, near and far, and face it from many sides.";
  for (std::size_t v = 0; v < data.views.size(); ++v)
    content.boards.push_back({.target = &data.boards[data.views[v].board].target,
                              .scene_from_board = data.views[v].camera_from_board,
                              .view = v});
  if (data.next_view)
    content.boards.push_back({.target = &data.boards[data.next_view->board].target,
                              .scene_from_board = data.next_view->camera_from_board,
                              .is_next = true});
  content.cameras.push_back({.camera = &data.camera, .size = data.size});
  return sceneFigure(content);
}

}  // namespace alidade
