// SPDX-License-Identifier: MIT
#include "alidade/report/figures/rig_figures.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "alidade/core/mapped.h"
#include "alidade/report/data/distinct_parts.h"
#include "alidade/report/figures/scene_figure.h"

namespace alidade {
namespace {

using Eigen::Vector2d;

constexpr std::size_t kNumHues = 3;  // classes hue0 to hue2 of the style sheet

std::string pairName(const ReportedRig& rig, const EpipolarPair& pair) {
  return rig.cameras[pair.first].name + " – " + rig.cameras[pair.second].name;
}

const EpipolarPair& worstOf(const std::vector<EpipolarPair>& pairs) {
  return *std::ranges::max_element(pairs, {}, &EpipolarPair::rms_px);
}

}  // namespace

Figure rigSceneFigure(const ReportedRig& rig) {
  const auto boardOf = [&](const ReportedPlacement& placement) {
    return SceneBoard{.target = &rig.boards[placement.board],
                      .scene_from_board = placement.rig_from_board,
                      .words = "frame " + rig.frames[placement.frame]};
  };
  std::vector<SceneCamera> cameras;
  for (const ReportedRigCamera& camera : rig.cameras)
    cameras.push_back({.camera = &camera.camera,
                       .size = camera.size,
                       .scene_from_camera = camera.camera_from_rig.inverse(),
                       .name = camera.name});
  return sceneFigure(
      {.title = "Cameras and boards in space",
       .reading = "Drag the drawing, or select it and use the arrow keys, to turn it; the cameras should "
                  "stand as they do on your rig, and boards between two cameras link them."},
      mapped(rig.placements, boardOf), cameras, 0.1);
}

Figure epipolarFigure(const ReportedRig& rig, const std::vector<EpipolarPair>& pairs) {
  constexpr double kRow = 24;
  constexpr double kNames = 150;
  constexpr std::size_t kMostLetters = 24;
  const EpipolarPair& worst = worstOf(pairs);
  const double most = worst.rms_px > 0 ? worst.rms_px : 1;
  const double bottom = 24 + kRow * static_cast<double>(pairs.size());
  FigureCanvas canvas(
      {.box = {Vector2d(kNames, 14), Vector2d(360, bottom)}, .low = {0, 0}, .high = {most, 1}}, 4);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const EpipolarPair& pair = pairs[i];
    const double top = 14 + kRow * static_cast<double>(i);
    std::string name = pairName(rig, pair);
    if (name.size() > kMostLetters) name = fmt::format("{} – {}", pair.first + 1, pair.second + 1);
    canvas.addText({kNames - 8, top + 15}, name, "end");
    const double end = canvas.at(pair.rms_px, 0).x();
    canvas.addRect(
        {kNames, top + 3}, {std::max(end, kNames + 1), top + kRow - 3},
        fmt::format("class=\"bar\" data-rms=\"{:.9g}\" data-tell=\"{}\"", pair.rms_px,
                    escapedMarkup(fmt::format("{}: {} corners", pairName(rig, pair), pair.num_corners))));
    canvas.addText({end + 6, top + 15}, shortNumber(pair.rms_px) + " px", "start", "tick");
  }
  canvas.addLine({kNames, 12}, {kNames, bottom}, "frame");
  return canvas.drawn(
      {.id = "epipolar",
       .title = "Epipolar error by pair",
       .reading =
           "Each bar is the RMS distance of corners from the epipolar lines of the same corners in the "
           "other camera; a pair that stands out is not synchronised, or one of its lenses is wrong.",
       .alt = fmt::format("Epipolar errors of {} pairs of cameras; the largest is {} px, of {}.",
                          pairs.size(), shortNumber(worst.rms_px), pairName(rig, worst))});
}

namespace {

// Figures over time are stacked, with frames at the same horizontal positions.
constexpr double kTimeLeft = 96;
constexpr double kTimeRight = 430;

PlotArea timeArea(const ReportedRig& rig, double top, double bottom, double most) {
  const auto count = static_cast<double>(std::max<std::size_t>(1, rig.frames.size()));
  return {.box = {Vector2d(kTimeLeft, top), Vector2d(kTimeRight, bottom)},
          .low = {0.5, 0},
          .high = {count + 0.5, most}};
}

double middleOf(std::size_t frame) {
  return static_cast<double>(frame) + 1;
}

// A line through the frames in which both cameras saw a board, with a gap where they did not.
std::string coursePath(const EpipolarPair& pair, const PlotArea& area) {
  std::string d;
  std::size_t expected = 0;
  for (const auto& [frame, rms] : pair.by_frame) {
    d += (d.empty() || frame != expected ? "M" : "L") + pointText(area.at(middleOf(frame), rms));
    expected = frame + 1;
  }
  return d;
}

// The names of the images that a camera took in a frame.
std::string imagesIn(const ReportedRig& rig, std::size_t camera, std::size_t frame) {
  std::string names;
  for (const ReportedView& view : rig.views) {
    if (view.camera != camera || rig.placements[view.placement].frame != frame) continue;
    if (names.find(view.image) == std::string::npos) names += (names.empty() ? "" : ", ") + view.image;
  }
  return names;
}

}  // namespace

Figure epipolarOverTimeFigure(const ReportedRig& rig, const std::vector<EpipolarPair>& pairs) {
  constexpr std::size_t kMostDots = 1500;
  double most = 0;
  std::size_t num_dots = 0;
  for (const EpipolarPair& pair : pairs) {
    for (const auto& [frame, rms] : pair.by_frame) most = std::max(most, rms);
    num_dots += pair.by_frame.size();
  }
  if (!(most > 0)) most = 1;
  FigureCanvas canvas(timeArea(rig, 24, 190, 1.06 * most), 39);
  const PlotArea& area = canvas.area();
  canvas.addNamedAxes(distinctParts(rig.frames), "frame", "epipolar error, px");
  // The pairs with the largest errors have their own colours.
  std::vector<EpipolarPair> order = pairs;
  std::ranges::stable_sort(order, std::ranges::greater(), &EpipolarPair::rms_px);
  Legend legend;
  std::string others;
  for (std::size_t rank = kNumHues; rank < order.size(); ++rank) others += coursePath(order[rank], area);
  canvas.addPath(others, "residuals course");
  for (std::size_t rank = 0; rank < std::min(kNumHues, order.size()); ++rank) {
    const EpipolarPair& pair = order[rank];
    canvas.addPath(coursePath(pair, area), fmt::format("class=\"hue{} course\"", rank));
    for (const auto& [frame, rms] : pair.by_frame) {
      const Vector2d at = area.at(middleOf(frame), rms);
      if (num_dots > kMostDots) continue;
      canvas.addPath("M" + pointText(at) + "h0",
                     fmt::format("class=\"hue{} places\" data-frame=\"{}\" data-tell=\"{}\"", rank, frame,
                                 escapedMarkup(fmt::format("{}, frame {}: {} px; {}, {}", pairName(rig, pair),
                                                           rig.frames[frame], shortNumber(rms),
                                                           imagesIn(rig, pair.first, frame),
                                                           imagesIn(rig, pair.second, frame)))));
    }
    legend.emplace_back(fmt::format("line hue{} course", rank), pairName(rig, pair));
  }
  if (!others.empty()) legend.emplace_back("line residuals", "other pairs");
  const bool do_times_differ =
      std::ranges::find(rig.findings, DiagnosisId("exposures_differ"), &Diagnosis::id) != rig.findings.end();
  return canvas.drawn(
      {.id = "epipolar-time",
       .title = "Epipolar error over time",
       .reading =
           std::string(do_times_differ
                           ? "The cameras do not take a frame at one instant, so the lines rise where the "
                             "board moves; the rig takes this into account."
                           : "The lines should be level; a step means that a camera moved on the rig, and a "
                             "single peak that a frame was not taken at the same time.") +
           " Lines are broken where a frame has no common board.",
       .alt = fmt::format("Epipolar errors of {} pairs in {} frames, at most {} px.", pairs.size(),
                          rig.frames.size(), shortNumber(most))},
      legend);
}

Figure frameErrorsFigure(const ReportedRig& rig) {
  std::map<std::pair<std::size_t, std::size_t>, SquareSum> cells;
  for (const ReportedView& view : rig.views) {
    SquareSum& cell = cells[{view.camera, rig.placements[view.placement].frame}];
    for (const CornerError& corner : view.corners) cell.sum += corner.error_px.squaredNorm();
    cell.count += view.corners.size();
  }
  double most = 0;
  for (const auto& [key, cell] : cells) most = std::max(most, cell.rms());
  constexpr double kRow = 26;
  constexpr double kTop = 10;
  const double bottom = kTop + kRow * static_cast<double>(rig.cameras.size());
  FigureCanvas canvas(timeArea(rig, kTop, bottom, 1), 40);
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    const double top = kTop + kRow * static_cast<double>(c);
    canvas.addText({kTimeLeft - 6, top + 17}, rig.cameras[c].name.substr(0, 13), "end");
    canvas.addRect({kTimeLeft, top}, {kTimeRight, top + kRow}, "empty");
  }
  for (const auto& [key, cell] : cells) {
    const auto& [camera, frame] = key;
    const double top = kTop + kRow * static_cast<double>(camera);
    const double left = canvas.at(middleOf(frame) - 0.5, 0).x();
    const double right = canvas.at(middleOf(frame) + 0.5, 0).x();
    const double gap = std::min(0.3, 0.1 * (right - left));
    const double rms = cell.rms();
    canvas.addRect({left + gap, top + 0.5}, {right - gap, top + kRow - 0.5},
                   fmt::format("class=\"warmth\" fill-opacity=\"{:.2f}\" data-count=\"{}\" "
                               "data-rms=\"{:.9g}\" data-frame=\"{}\" data-tell=\"{}\"",
                               0.1 + 0.5 * (most > 0 ? rms / most : 0), cell.count, rms, frame,
                               escapedMarkup(fmt::format("{}, frame {}: RMS {} px, {}",
                                                         rig.cameras[camera].name, rig.frames[frame],
                                                         shortNumber(rms), imagesIn(rig, camera, frame)))));
  }
  canvas.addNames(distinctParts(rig.frames), "frame");
  Legend legend = warmthLegend(most);
  legend.emplace_back("empty", "no board");
  canvas.addLegend({kTimeLeft, bottom + 38}, legend);
  return canvas.drawn(
      {.id = "frame-errors",
       .title = "Error by camera and frame",
       .reading =
           "Each cell is one image, and strong colours are large errors: a single strong cell is a bad "
           "image, a strong column a frame that was not taken at the same time, and a strong row a "
           "camera with a wrong lens.",
       .alt = fmt::format("RMS of {} images of {} cameras in {} frames, at most {} px.", cells.size(),
                          rig.cameras.size(), rig.frames.size(), shortNumber(most))});
}

}  // namespace alidade
