// SPDX-License-Identifier: MIT
#include "alidade/report/figures/camera_figures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "alidade/core/degrees.h"
#include "alidade/core/mapped.h"
#include "alidade/print/ink_of_board.h"
#include "alidade/report/data/distinct_parts.h"

namespace alidade {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kMarkedTiltRad = 0.087;  // from 5 degrees on, as in the words for the next view

// True if a warning or a failure names an image.
bool isNamed(const ReportData& data, const std::string& image) {
  return !image.empty() && std::ranges::any_of(data.findings, [&](const Diagnosis& finding) {
    return finding.severity >= Severity::kWarning && finding.message().find(image) != std::string::npos;
  });
}

double totalTilt(const BoardTilt& tilt) {
  return std::acos(std::clamp(std::cos(tilt.right_rad) * std::cos(tilt.lower_rad), -1.0, 1.0));
}

bool isKnown(const BoardTilt& tilt) {
  return !std::isnan(tilt.right_rad + tilt.lower_rad);
}

// A pose of a board in front of a camera, and the drawing of its image.
struct DrawnPose {
  const AnyCamera& camera;
  SE3 camera_from_board;
  const PlotArea& area;

  // The projection of a point of a board's plane.
  [[nodiscard]] Projection seen(const Vector2d& point) const {
    return camera.projectPoint(camera_from_board * Vector3d(point.x(), point.y(), 0));
  }
  // The image of a closed line on a board; empty where a part of it has no pixel.
  [[nodiscard]] std::string path(const std::vector<Vector2d>& line) const {
    std::vector<Vector2d> outline;
    for (const Vector2d& point : line) {
      const Projection at = seen(point);
      if (!at.ok()) return "";
      outline.push_back(area.at(at.pixel));
    }
    return pathThrough(outline, true);
  }
};

std::string projectedOutline(const DrawnPose& pose, const Eigen::AlignedBox2d& box, int steps) {
  const std::vector<Vector2d> around = cornersOf(box);
  std::vector<Vector2d> outline;
  for (std::size_t side = 0; side < 4; ++side) {
    for (int i = 0; i < steps; ++i) {
      const double t = static_cast<double>(i) / steps;
      outline.emplace_back((1 - t) * around[side] + t * around[(side + 1) % 4]);
    }
  }
  return pose.path(outline);
}

std::string projectedDisc(const DrawnPose& pose, const Eigen::AlignedBox2d& disc) {
  constexpr int kSteps = 24;
  std::vector<Vector2d> outline;
  for (int i = 0; i < kSteps; ++i) {
    const double angle = 2 * std::numbers::pi * i / kSteps;
    outline.emplace_back(disc.center() + 0.5 * disc.sizes().x() * Vector2d(std::cos(angle), std::sin(angle)));
  }
  return pose.path(outline);
}

// The paper in pieces, so that only those that the camera cannot see are omitted.
std::string projectedSheet(const DrawnPose& pose, const Eigen::AlignedBox2d& sheet, double piece_m) {
  const int columns = std::clamp(static_cast<int>(std::ceil(sheet.sizes().x() / piece_m)), 1, 60);
  const int rows = std::clamp(static_cast<int>(std::ceil(sheet.sizes().y() / piece_m)), 1, 60);
  const Vector2d piece = sheet.sizes().cwiseQuotient(Vector2d(columns, rows));
  std::string d;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const Vector2d low = sheet.min() + piece.cwiseProduct(Vector2d(column, row));
      d += projectedOutline(pose, {low, low + piece}, 2);
    }
  }
  return d;
}

std::string projectedInk(const DrawnPose& pose, const BoardInk& ink) {
  std::string d;
  for (const Eigen::AlignedBox2d& box : ink.boxes) d += projectedOutline(pose, box, 2);
  for (const Eigen::AlignedBox2d& disc : ink.discs) d += projectedDisc(pose, disc);
  return d;
}

// Enough corners to show the covered area; all of them would make a large file.
std::string seenCorners(const ReportData& data, const PlotArea& area) {
  std::string dots;
  for (const ReportedView& view : data.views) {
    const std::size_t step = 1 + view.corners.size() * data.views.size() / 3000;
    for (std::size_t i = 0; i < view.corners.size(); i += step)
      dots += "M" + pointText(area.at(view.corners[i].pixel)) + "h0";
  }
  return dots;
}

// The pixels of an image and of a margin that contains the board, up to a fraction of the image's size.
Eigen::AlignedBox2d shownPixels(const DrawnPose& pose, const Eigen::AlignedBox2d& sheet,
                                const Eigen::AlignedBox2d& image) {
  constexpr double kMostMargin = 0.4;
  constexpr int kSteps = 12;
  Eigen::AlignedBox2d shown = image;
  for (int i = 0; i <= kSteps; ++i) {
    for (int k = 0; k <= kSteps; ++k) {
      const Vector2d share(static_cast<double>(i) / kSteps, static_cast<double>(k) / kSteps);
      const Projection seen = pose.seen(sheet.min() + share.cwiseProduct(sheet.sizes()));
      if (seen.ok()) shown.extend(seen.pixel);
    }
  }
  const Vector2d most = kMostMargin * image.sizes();
  Eigen::AlignedBox2d around(image.min() - most, image.max() + most);
  return shown.intersection(around);
}

// The sides that must come nearer, as thick lines with labels. Directions are those of the image.
void addNearerSides(const DrawnPose& pose, const BoardTilt& tilt, const BoardInk& ink, FigureCanvas& canvas) {
  constexpr int kSteps = 24;
  constexpr double kWordsWidth = 106;
  const Vector2d centre = ink.extent.center();
  const Vector2d half_board = 0.5 * ink.extent.sizes();
  const PlotArea& area = canvas.area();
  const Projection middle = pose.seen(centre);
  if (!middle.ok()) return;
  // The image of a step on the board; a side beyond the image may have no pixels.
  const auto inImage = [&](const Vector2d& on_board) -> Vector2d {
    const Projection seen = pose.seen(centre + 0.02 * half_board.cwiseProduct(on_board));
    return seen.ok() ? (seen.pixel - middle.pixel).normalized() : Vector2d(0, 0);
  };
  const auto mark = [&](const Vector2d& direction) {
    const std::array<Vector2d, 4> outward = {Vector2d(1, 0), Vector2d(-1, 0), Vector2d(0, 1),
                                             Vector2d(0, -1)};
    const Vector2d side =
        *std::ranges::max_element(outward, {}, [&](const Vector2d& o) { return inImage(o).dot(direction); });
    const Vector2d along(side.y(), side.x());
    std::vector<Vector2d> visible;
    std::string line;
    bool goes_on = false;  // continues from the last point, which was visible too
    for (int i = 0; i <= kSteps; ++i) {
      const Projection seen =
          pose.seen(centre + half_board.cwiseProduct(side + (2.0 * i / kSteps - 1) * along));
      const bool is_visible = seen.ok() && area.box.contains(area.at(seen.pixel));
      if (is_visible) {
        visible.push_back(area.at(seen.pixel));
        line += (goes_on ? "L" : "M") + pointText(visible.back());
      }
      goes_on = is_visible;
    }
    canvas.addPath(line, "nearer");
    // Outside the board if there is room, and at the border of the image for a side beyond it.
    const Vector2d half(0.5 * kWordsWidth, 9);
    Vector2d place = area.at(middle.pixel) + area.box.sizes().cwiseProduct(direction);
    if (!visible.empty()) place = visible[visible.size() / 2] + direction.cwiseProduct(half + Vector2d(6, 6));
    place = place.cwiseMax(area.box.min() + half + Vector2d(3, 3))
                .cwiseMin(area.box.max() - half - Vector2d(3, 3));
    if (visible.empty()) {  // an arrow points to it
      place -= 26 * direction;
      canvas.addPath(arrowPath(place + direction.cwiseProduct(half + Vector2d(3, 3)), 22 * direction),
                     "nearer");
    }
    canvas.addRect(place - half, place + half, "class=\"plate\" rx=\"4\"");
    canvas.addText(place + Vector2d(0, 4), "this side nearer", "middle", "nearer-words");
  };
  if (std::abs(tilt.right_rad) > kMarkedTiltRad) mark({tilt.right_rad > 0 ? 1 : -1, 0});
  if (std::abs(tilt.lower_rad) > kMarkedTiltRad) mark({0, tilt.lower_rad > 0 ? 1 : -1});
}

const char* starWords(const CalibrationEvidence& data) {
  return data.next_view ? " The star is the next photograph." : "";
}

}  // namespace

Figure viewErrorsFigure(const ReportData& data) {
  double most = 0;
  double worst_rms = 0;
  for (const ReportedView& view : data.views) {
    most = std::max(most, view.max_error_px);
    worst_rms = std::max(worst_rms, view.rms_px);
  }
  most = std::min(most, 6 * worst_rms);  // one extreme corner must not flatten the bars
  if (!(most > 0)) most = 1;
  const auto count = static_cast<double>(data.views.size());
  FigureCanvas canvas(Vector2d(0.5, 0), Vector2d(count + 0.5, 1.06 * most));
  const PlotArea& area = canvas.area();
  canvas.addNamedAxes(distinctParts(mapped(data.views, &ReportedView::image)), "image", "error, px");
  const double gap = count <= 120 ? 0.12 : 0;
  std::string largest;
  bool is_any_named = false;
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    const ReportedView& view = data.views[v];
    const double x = static_cast<double>(v) + 1;
    const bool is_named = isNamed(data, view.image);
    is_any_named = is_any_named || is_named;
    canvas.addRect(area.at(x - 0.5 + gap, view.rms_px), area.at(x + 0.5 - gap, 0),
                   fmt::format("class=\"bar{}\" data-view=\"{}\" data-rms=\"{:.9g}\"",
                               is_named ? " named" : "", data.first_view + v, view.rms_px));
    const double top = std::min(view.max_error_px, 1.06 * most);
    largest += pathThrough({area.at(x - 0.5 + gap, top), area.at(x + 0.5 - gap, top)});
  }
  canvas.addPath(largest, "largest");
  canvas.addLine(area.at(0.5, data.rms_px), area.at(count + 0.5, data.rms_px), "reference");
  Legend legend = {{"bar", "RMS of the view"}};
  if (is_any_named) legend.emplace_back("bar named", "named in a warning");
  legend.emplace_back("line largest", "largest error");
  legend.emplace_back("line reference", fmt::format("RMS of all, {} px", shortNumber(data.rms_px)));
  const auto worst = std::ranges::max_element(data.views, {}, &ReportedView::rms_px);
  std::string alt = fmt::format("RMS of {} views.", data.views.size());
  if (worst != data.views.end())
    alt += fmt::format(" The largest is {} px, in {}.", shortNumber(worst->rms_px), worst->image);
  return canvas.drawn(
      {.id = "view-errors",
       .title = "Error by view",
       .reading = "The bars should be about equally high; look at the photograph of one that stands out, for "
                  "blur, movement or glare (click a bar to open it).",
       .alt = alt},
      legend);
}

Figure tiltFigure(const CalibrationEvidence& data) {
  constexpr double kMostRad = std::numbers::pi * 75 / 180;
  const Vector2d middle(220, 158);
  constexpr double kRadius = 130;
  const auto at = [&](const BoardTilt& tilt) -> Vector2d {
    const Vector2d direction(std::sin(tilt.right_rad), std::sin(tilt.lower_rad));
    if (direction.norm() < 1e-9) return middle;
    return middle + kRadius * std::min(1.0, totalTilt(tilt) / kMostRad) * direction.normalized();
  };
  FigureCanvas canvas(316);
  canvas.addCircle(middle, kRadius, "paper");
  const auto ringOf = [](double degrees) { return kRadius * degrees / kDegPerRad / kMostRad; };
  for (const double degrees : {15, 30, 45, 60, 75}) canvas.addCircle(middle, ringOf(degrees), "ring");
  canvas.addLine(middle - Vector2d(kRadius, 0), middle + Vector2d(kRadius, 0), "grid");
  canvas.addLine(middle - Vector2d(0, kRadius), middle + Vector2d(0, kRadius), "grid");
  int num_tilted = 0;
  for (const ReportedView& view : data.views) {
    if (!isKnown(view.tilt)) continue;
    num_tilted += totalTilt(view.tilt) > kMostRad / 5 ? 1 : 0;
    canvas.addCircle(at(view.tilt), 4, "view");
  }
  for (const double degrees : {15, 30, 45, 60, 75}) {
    canvas.addText(middle + ringOf(degrees) * Vector2d(0.4, -0.9165) + Vector2d(2, -2),
                   fmt::format("{:.0f}°", degrees), "start", "tick halo");
  }
  if (data.next_view) canvas.addPath(starPath(at(data.next_view->tilt), 9), "next");
  canvas.addText(middle + Vector2d(kRadius + 6, 4), "right nearer", "start", "axis");
  canvas.addText(middle + Vector2d(-kRadius - 6, 4), "left nearer", "end", "axis");
  canvas.addText(middle + Vector2d(0, -kRadius - 8), "upper side nearer", "middle", "axis");
  canvas.addText(middle + Vector2d(0, kRadius + 16), "lower side nearer", "middle", "axis");
  Legend legend = {{"dot view", "view"}};
  if (data.next_view) legend.emplace_back("star next", "suggested next view");
  canvas.addLegend({44, 316}, legend);
  return canvas.drawn(
      {.id = "tilts",
       .title = "How the board was tilted",
       .reading =
           std::string("Each dot is a view, placed towards the side of the board that was nearer to the "
                       "camera; dots should lie on all sides between 20 and 50 degrees. Tilt counts from the "
                       "pose in which this lens shows the board square: without distortion that is parallel "
                       "to the image, and with it a few degrees off towards the border.") +
           starWords(data),
       .alt =
           fmt::format("{} of {} views are tilted by more than 15 degrees.", num_tilted, data.views.size())});
}

Figure distanceFigure(const CalibrationEvidence& data) {
  double farthest = data.next_view ? data.next_view->distance_m : 0;
  double most_tilt = 60;
  for (const ReportedView& view : data.views) {
    farthest = std::max(farthest, view.distance_m);
    const double tilt = kDegPerRad * totalTilt(view.tilt);
    if (tilt > most_tilt) most_tilt = tilt;
  }
  if (!(farthest > 0)) farthest = 1;
  FigureCanvas canvas({.box = {Vector2d(44, 24), Vector2d(430, 268)},
                       .low = {0, 0},
                       .high = {1.08 * farthest, std::min(92.0, 1.06 * most_tilt)}},
                      37);
  canvas.addAxes("distance of the board, m", "tilt, degrees");
  const auto at = [&](double distance_m, const BoardTilt& tilt) {
    return canvas.at(distance_m, std::min(kDegPerRad * totalTilt(tilt), canvas.area().high.y()));
  };
  double nearest = farthest;
  for (const ReportedView& view : data.views) {
    if (!isKnown(view.tilt)) continue;
    nearest = std::min(nearest, view.distance_m);
    canvas.addCircle(at(view.distance_m, view.tilt), 4, "view");
  }
  Legend legend = {{"dot view", "view"}};
  if (data.next_view) {
    canvas.addPath(starPath(at(data.next_view->distance_m, data.next_view->tilt), 9), "next");
    legend.emplace_back("star next", "suggested next view");
  }
  return canvas.drawn(
      {.id = "distances",
       .title = "How far away the board was",
       .reading = "Each dot is a view; a good set has near and far boards, and most of them tilted." +
                  std::string(starWords(data)),
       .alt = fmt::format("Boards were {} to {} m away.", shortNumber(nearest), shortNumber(farthest))},
      legend);
}

Figure nextViewFigure(const CalibrationEvidence& data) {
  const ReportedView& next = *data.next_view;
  const Board& target = data.boards[next.board].target;
  const BoardInk ink = inkOf(target);
  Eigen::AlignedBox2d sheet = ink.extent;
  const Vector2d margin = Vector2d::Constant(0.35 * target.spacing());
  sheet.extend(sheet.min() - margin);
  sheet.extend(sheet.max() + margin);
  // The image and enough of its surroundings to show where the board continues.
  const Eigen::AlignedBox2d image(Vector2d(-0.5, -0.5),
                                  Vector2d(data.size.width - 0.5, data.size.height - 0.5));
  PlotArea area;
  const DrawnPose pose{.camera = data.camera, .camera_from_board = next.camera_from_board, .area = area};
  const Eigen::AlignedBox2d shown = shownPixels(pose, sheet, image);
  area = imageArea({.width = static_cast<int>(std::lround(shown.sizes().x())),
                    .height = static_cast<int>(std::lround(shown.sizes().y()))},
                   FigureCanvas::kWidth);
  area.low = shown.min();
  area.high = shown.max();
  const Vector2d image_low = area.at(image.min());
  const Vector2d image_high = area.at(image.max());
  FigureCanvas canvas(area, FigureCanvas::kMarks - 12);  // no marks here
  canvas.addRect(image_low, image_high, "scene");
  canvas.addPath(seenCorners(data, area), "corners faint");
  canvas.addRaw("<clipPath id=\"next-clip\">");
  canvas.addRect(image_low, image_high, "");
  canvas.addRaw("</clipPath><clipPath id=\"next-ghost-clip\">");
  canvas.addArea("");
  canvas.addRaw("</clipPath>\n<defs>");
  canvas.open("id=\"next-board\"");
  canvas.addPath(projectedSheet(pose, sheet, target.spacing()), "sheet");
  canvas.addPath(projectedInk(pose, ink), "print");
  canvas.close();
  canvas.addRaw(
      "</defs>\n<use href=\"#next-board\" class=\"ghost\" clip-path=\"url(#next-ghost-clip)\"/><use "
      "href=\"#next-board\" clip-path=\"url(#next-clip)\"/>\n");
  canvas.addPath(projectedOutline(pose, sheet, 24),
                 "class=\"ghost-outline\" clip-path=\"url(#next-ghost-clip)\"");
  canvas.addRect(image_low, image_high, "frame strong-frame");
  addNearerSides(pose, next.tilt, ink, canvas);
  const bool is_beyond = !image.contains(shown);
  Legend legend = {{"sheet", "the board in the next photograph"}, {"dot corner", "corners seen so far"}};
  if (is_beyond) legend.emplace_back("line ghost-outline", "the board beyond the image");
  return canvas.drawn(
      {.id = "next-view",
       .title = "The next photograph",
       .reading = fmt::format(
           "This is what the camera should see: move the board until your picture looks like this one.{}",
           is_beyond ? " A part of the board lies beyond the border of the image; that part is drawn pale."
                     : ""),
       .alt = "The suggested next photograph: " + data.next_text + "."},
      legend);
}

std::string cornersPicture(const ReportData& data, const ReportedView& view) {
  constexpr double kPictureWidth = 160;
  const double scale = kPictureWidth / data.size.width;
  FigureCanvas canvas(scale * data.size.height, kPictureWidth);
  std::string dots;
  for (const CornerError& corner : view.corners)
    dots += "M" + pointText(scale * (corner.pixel + Vector2d(0.5, 0.5))) + "h0";
  canvas.addPath(dots, "corners");
  return canvas.svg("");
}

}  // namespace alidade
