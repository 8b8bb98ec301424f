// SPDX-License-Identifier: MIT
#include "alidade/report/rig_figures.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "alidade/report/scene_figure.h"

namespace alidade {
namespace {

using Eigen::Vector2d;

constexpr std::size_t kNumHues = 5;  // classes hue0 to hue4 of the style sheet

std::string pairName(const ReportedRig& rig, const EpipolarPair& pair) {
  return rig.cameras[pair.first].name + " – " + rig.cameras[pair.second].name;
}

const EpipolarPair& worstOf(const std::vector<EpipolarPair>& pairs) {
  return *std::ranges::max_element(pairs, {}, &EpipolarPair::rms_px);
}

}  // namespace

Figure rigSceneFigure(const ReportedRig& rig) {
  SceneContent content{.title = "Cameras and boards in space", .reading = {}};
  content.reading =
      "Drag the drawing, or select it and use the arrow keys, to turn it; the cameras should stand as they "
      "do on your "
      "rig, and boards between two cameras link them.";
  content.camera_share = 0.1;
  for (const ReportedPlacement& placement : rig.placements)
    content.boards.push_back({.target = &rig.boards[placement.board],
                              .scene_from_board = placement.rig_from_board,
                              .words = "frame " + rig.frames[placement.frame]});
  for (const ReportedRigCamera& camera : rig.cameras)
    content.cameras.push_back({.camera = &camera.camera,
                               .size = camera.size,
                               .scene_from_camera = camera.camera_from_rig.inverse(),
                               .name = camera.name});
  return sceneFigure(content);
}

Figure epipolarFigure(const ReportedRig& rig, const std::vector<EpipolarPair>& pairs) {
  constexpr double kRow = 24;
  constexpr double kNames = 150;
  constexpr std::size_t kMostLetters = 24;
  const EpipolarPair& worst = worstOf(pairs);
  const double most = worst.rms_px > 0 ? worst.rms_px : 1;
  const double bottom = 24 + kRow * static_cast<double>(pairs.size());
  const PlotArea area{.box = {Vector2d(kNames, 14), Vector2d(390, bottom)}, .low = {0, 0}, .high = {most, 1}};
  FigureCanvas canvas(bottom + 4);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const EpipolarPair& pair = pairs[i];
    const double top = 14 + kRow * static_cast<double>(i);
    std::string name = pairName(rig, pair);
    if (name.size() > kMostLetters) name = fmt::format("{} – {}", pair.first + 1, pair.second + 1);
    canvas.addText({kNames - 8, top + 15}, name, "end");
    const double end = area.at(pair.rms_px, 0).x();
    canvas.addRect(
        {kNames, top + 3}, {std::max(end, kNames + 1), top + kRow - 3},
        fmt::format("class=\"bar\" data-rms=\"{:.9g}\" data-tell=\"{}\"", pair.rms_px,
                    escapedMarkup(fmt::format("{}: {} corners", pairName(rig, pair), pair.num_corners))));
    canvas.addText({end + 6, top + 15}, twoDigits(pair.rms_px) + " px", "start", "class=\"tick\"");
  }
  canvas.addLine({kNames, 12}, {kNames, bottom}, "class=\"frame\"");
  Figure figure{.id = "epipolar", .title = "Epipolar error by pair"};
  figure.reading =
      "Each bar is the RMS distance of corners from the epipolar lines of the same corners in the other "
      "camera; a pair "
      "that stands out is not synchronised, or one of its lenses is wrong.";
  figure.alt = fmt::format("Epipolar errors of {} pairs of cameras; the largest is {} px, of {}.",
                           pairs.size(), twoDigits(worst.rms_px), pairName(rig, worst));
  figure.svg = canvas.svg(figure.alt);
  return figure;
}

Figure epipolarOverTimeFigure(const ReportedRig& rig, const std::vector<EpipolarPair>& pairs) {
  double most = 0;
  for (const EpipolarPair& pair : pairs)
    for (const auto& [frame, rms] : pair.by_frame) most = std::max(most, rms);
  if (!(most > 0)) most = 1;
  const auto count = static_cast<double>(rig.frames.size());
  const PlotArea area{
      .box = {Vector2d(44, 24), Vector2d(890, 190)}, .low = {0.5, 0}, .high = {count + 0.5, 1.06 * most}};
  FigureCanvas canvas(229, 900);
  canvas.addAxes(area, "frame, in order of names", "epipolar error, px");
  // Of many pairs those with the largest errors have colours of their own.
  std::vector<std::size_t> order(pairs.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::ranges::stable_sort(order,
                           [&](std::size_t a, std::size_t b) { return pairs[a].rms_px > pairs[b].rms_px; });
  std::vector<std::pair<std::string, std::string>> legend;
  std::string others;
  for (std::size_t rank = 0; rank < order.size(); ++rank) {
    const EpipolarPair& pair = pairs[order[rank]];
    std::vector<Vector2d> points;
    std::string dots;
    for (const auto& [frame, rms] : pair.by_frame) {
      points.push_back(area.at(static_cast<double>(frame) + 1, rms));
      dots += "M" + pointText(points.back()) + "h0";
    }
    if (rank >= kNumHues) {
      others += pathThrough(points);
      continue;
    }
    canvas.addPath(pathThrough(points), fmt::format("class=\"hue{} course\"", rank));
    canvas.addPath(dots, fmt::format("class=\"hue{} places\"", rank));
    legend.emplace_back(fmt::format("line hue{} course", rank), pairName(rig, pair));
  }
  canvas.addPath(others, "class=\"residuals\"");
  if (!others.empty()) legend.emplace_back("line residuals", "other pairs");
  canvas.addLegend({area.box.min().x(), 229}, legend);
  Figure figure{.id = "epipolar-time", .title = "Epipolar error over time", .is_wide = true};
  figure.reading =
      "The lines should be level; a step means that a camera moved on the rig, and a single peak that a "
      "frame was not "
      "taken at the same time.";
  figure.alt = fmt::format("Epipolar errors of {} pairs in {} frames, at most {} px.", pairs.size(),
                           rig.frames.size(), twoDigits(most));
  figure.svg = canvas.svg(figure.alt);
  return figure;
}

Figure frameErrorsFigure(const ReportedRig& rig) {
  struct CellErrors {
    double sum = 0;
    std::size_t count = 0;
  };
  std::map<std::pair<std::size_t, std::size_t>, CellErrors> cells;
  for (const ReportedRigView& view : rig.views) {
    CellErrors& cell = cells[{view.camera, rig.placements[view.placement].frame}];
    for (const ReportedCorner& corner : view.corners) cell.sum += corner.error_px.squaredNorm();
    cell.count += view.corners.size();
  }
  const auto rmsOf = [](const CellErrors& cell) {
    return cell.count == 0 ? 0 : std::sqrt(cell.sum / static_cast<double>(cell.count));
  };
  double most = 0;
  for (const auto& [key, cell] : cells) most = std::max(most, rmsOf(cell));
  constexpr double kNames = 120;
  constexpr double kRow = 26;
  constexpr double kTop = 10;
  const auto num_frames = static_cast<double>(std::max<std::size_t>(1, rig.frames.size()));
  const double width = (890 - kNames) / num_frames;
  const double bottom = kTop + kRow * static_cast<double>(rig.cameras.size());
  FigureCanvas canvas(bottom + 40, 900);
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    const double top = kTop + kRow * static_cast<double>(c);
    canvas.addText({kNames - 8, top + 17}, rig.cameras[c].name.substr(0, 24), "end");
    canvas.addRect({kNames, top}, {890, top + kRow}, "class=\"empty\"");
  }
  for (const auto& [key, cell] : cells) {
    const Vector2d low(kNames + width * static_cast<double>(key.second),
                       kTop + kRow * static_cast<double>(key.first));
    const double rms = rmsOf(cell);
    canvas.addRect(
        low + Vector2d(0.3, 0.5), low + Vector2d(width - 0.3, kRow - 0.5),
        fmt::format(
            "class=\"warmth\" fill-opacity=\"{:.2f}\" data-count=\"{}\" data-rms=\"{:.9g}\" data-tell=\"{}\"",
            most > 0 ? 0.12 + 0.78 * rms / most : 0.12, cell.count, rms,
            escapedMarkup(fmt::format("{}, frame {}: RMS {} px", rig.cameras[key.first].name,
                                      rig.frames[key.second], shortNumber(rms)))));
  }
  canvas.addText({kNames + 0.5 * (890 - kNames), bottom + 16}, "frame, in order of names", "middle",
                 "class=\"axis\"");
  canvas.addLegend(
      {kNames, bottom + 26},
      {{"warmth", fmt::format("RMS of an image, darkest {} px", shortNumber(most))}, {"empty", "no board"}});
  Figure figure{.id = "frame-errors", .title = "Error by camera and frame", .is_wide = true};
  figure.reading =
      "Each cell is one image; a dark cell is a bad image, a dark column a frame that was not taken at the "
      "same time, and a "
      "dark row a camera with a wrong lens.";
  figure.alt = fmt::format("RMS of {} images of {} cameras in {} frames, at most {} px.", cells.size(),
                           rig.cameras.size(), rig.frames.size(), shortNumber(most));
  figure.svg = canvas.svg(figure.alt);
  return figure;
}

}  // namespace alidade
