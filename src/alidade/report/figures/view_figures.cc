// SPDX-License-Identifier: MIT
#include "alidade/report/figures/view_figures.h"

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

// The projection of a point of a board's plane.
Projection seenOnBoard(const ReportData& data, const SE3& camera_from_board, const Vector2d& point) {
  return data.camera.project(camera_from_board * Vector3d(point.x(), point.y(), 0));
}

// The image of a closed line on a board; empty where a part of it has no pixel.
std::string projectedPath(const ReportData& data, const SE3& camera_from_board,
                          const std::vector<Vector2d>& line, const PlotArea& area) {
  std::vector<Vector2d> outline;
  for (const Vector2d& point : line) {
    const Projection seen = seenOnBoard(data, camera_from_board, point);
    if (!seen.ok()) return "";
    outline.push_back(area.at(seen.pixel));
  }
  return pathThrough(outline, true);
}

std::string projectedOutline(const ReportData& data, const SE3& camera_from_board,
                             const Eigen::AlignedBox2d& box, int steps, const PlotArea& area) {
  const std::array<Vector2d, 4> around = {box.min(), Vector2d(box.max().x(), box.min().y()), box.max(),
                                          Vector2d(box.min().x(), box.max().y())};
  std::vector<Vector2d> outline;
  for (std::size_t side = 0; side < 4; ++side) {
    for (int i = 0; i < steps; ++i) {
      const double t = static_cast<double>(i) / steps;
      outline.emplace_back((1 - t) * around[side] + t * around[(side + 1) % 4]);
    }
  }
  return projectedPath(data, camera_from_board, outline, area);
}

std::string projectedDisc(const ReportData& data, const SE3& camera_from_board,
                          const Eigen::AlignedBox2d& disc, const PlotArea& area) {
  constexpr int kSteps = 24;
  std::vector<Vector2d> outline;
  for (int i = 0; i < kSteps; ++i) {
    const double angle = 2 * std::numbers::pi * i / kSteps;
    outline.emplace_back(disc.center() + 0.5 * disc.sizes().x() * Vector2d(std::cos(angle), std::sin(angle)));
  }
  return projectedPath(data, camera_from_board, outline, area);
}

// The paper in pieces, so that only those that the camera cannot see are omitted.
std::string projectedSheet(const ReportData& data, const SE3& camera_from_board,
                           const Eigen::AlignedBox2d& sheet, double piece_m, const PlotArea& area) {
  const int columns = std::clamp(static_cast<int>(std::ceil(sheet.sizes().x() / piece_m)), 1, 60);
  const int rows = std::clamp(static_cast<int>(std::ceil(sheet.sizes().y() / piece_m)), 1, 60);
  const Vector2d piece = sheet.sizes().cwiseQuotient(Vector2d(columns, rows));
  std::string d;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const Vector2d low = sheet.min() + piece.cwiseProduct(Vector2d(column, row));
      d += projectedOutline(data, camera_from_board, {low, low + piece}, 2, area);
    }
  }
  return d;
}

std::string projectedInk(const ReportData& data, const SE3& camera_from_board, const BoardInk& ink,
                         const PlotArea& area) {
  std::string d;
  for (const Eigen::AlignedBox2d& box : ink.boxes)
    d += projectedOutline(data, camera_from_board, box, 2, area);
  for (const Eigen::AlignedBox2d& disc : ink.discs) d += projectedDisc(data, camera_from_board, disc, area);
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
Eigen::AlignedBox2d shownPixels(const ReportData& data, const SE3& camera_from_board,
                                const Eigen::AlignedBox2d& sheet, const Eigen::AlignedBox2d& image) {
  constexpr double kMostMargin = 0.4;
  constexpr int kSteps = 12;
  Eigen::AlignedBox2d shown = image;
  for (int i = 0; i <= kSteps; ++i) {
    for (int k = 0; k <= kSteps; ++k) {
      const Vector2d share(static_cast<double>(i) / kSteps, static_cast<double>(k) / kSteps);
      const Projection seen =
          seenOnBoard(data, camera_from_board, sheet.min() + share.cwiseProduct(sheet.sizes()));
      if (seen.ok()) shown.extend(seen.pixel);
    }
  }
  const Vector2d most = kMostMargin * image.sizes();
  Eigen::AlignedBox2d around(image.min() - most, image.max() + most);
  return shown.intersection(around);
}

// The sides that must come nearer, as thick lines with labels. Directions are those of the image.
void addNearerSides(const ReportData& data, const ReportedNextView& next, const BoardInk& ink,
                    const PlotArea& area, FigureCanvas& canvas) {
  constexpr int kSteps = 24;
  constexpr double kWordsWidth = 106;
  const Vector2d centre = ink.extent.center();
  const Vector2d half_board = 0.5 * ink.extent.sizes();
  const auto seenAt = [&](const Vector2d& point) { return seenOnBoard(data, next.camera_from_board, point); };
  const Projection middle = seenAt(centre);
  if (!middle.ok()) return;
  // The image of a step on the board; a side beyond the image may have no pixels.
  const auto inImage = [&](const Vector2d& on_board) -> Vector2d {
    const Projection seen = seenAt(centre + 0.02 * half_board.cwiseProduct(on_board));
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
      const Projection seen = seenAt(centre + half_board.cwiseProduct(side + (2.0 * i / kSteps - 1) * along));
      const bool is_visible = seen.ok() && area.box.contains(area.at(seen.pixel));
      if (is_visible) {
        visible.push_back(area.at(seen.pixel));
        line += (goes_on ? "L" : "M") + pointText(visible.back());
      }
      goes_on = is_visible;
    }
    canvas.addPath(line, "class=\"nearer\"");
    // Outside the board if there is room, and at the border of the image for a side beyond it.
    const Vector2d half(0.5 * kWordsWidth, 9);
    Vector2d place = area.at(middle.pixel) + area.box.sizes().cwiseProduct(direction);
    if (!visible.empty()) place = visible[visible.size() / 2] + direction.cwiseProduct(half + Vector2d(6, 6));
    place = place.cwiseMax(area.box.min() + half + Vector2d(3, 3))
                .cwiseMin(area.box.max() - half - Vector2d(3, 3));
    if (visible.empty()) {  // an arrow points to it
      place -= 26 * direction;
      canvas.addPath(arrowPath(place + direction.cwiseProduct(half + Vector2d(3, 3)), 22 * direction),
                     "class=\"nearer\"");
    }
    canvas.addRect(place - half, place + half, "class=\"plate\" rx=\"4\"");
    canvas.addText(place + Vector2d(0, 4), "this side nearer", "middle", "class=\"nearer-words\"");
  };
  if (std::abs(next.tilt.right_rad) > kMarkedTiltRad) mark({next.tilt.right_rad > 0 ? 1 : -1, 0});
  if (std::abs(next.tilt.lower_rad) > kMarkedTiltRad) mark({0, next.tilt.lower_rad > 0 ? 1 : -1});
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
  const PlotArea area{
      .box = {Vector2d(44, 24), Vector2d(430, 250)}, .low = {0.5, 0}, .high = {count + 0.5, 1.06 * most}};
  FigureCanvas canvas(288);
  canvas.addNamedAxes(area, distinctParts(mapped(data.views, &ReportedView::image)), "image", "error, px");
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
  canvas.addPath(largest, "class=\"largest\"");
  canvas.addLine(area.at(0.5, data.rms_px), area.at(count + 0.5, data.rms_px), "class=\"reference\"");
  Legend legend = {{"bar", "RMS of the view"}};
  if (is_any_named) legend.emplace_back("bar named", "named in a warning");
  legend.emplace_back("line largest", "largest error");
  legend.emplace_back("line reference", fmt::format("RMS of all, {} px", shortNumber(data.rms_px)));
  canvas.addLegend({area.box.min().x(), 288}, legend);
  const auto worst = std::ranges::max_element(data.views, {}, &ReportedView::rms_px);
  Figure figure{.id = "view-errors", .title = "Error by view"};
  figure.reading =
      "The bars should be about equally high; look at the photograph of one that stands out, for blur, "
      "movement or glare (click a bar to open it).";
  figure.alt = fmt::format("RMS of {} views.", data.views.size());
  if (worst != data.views.end())
    figure.alt += fmt::format(" The largest is {} px, in {}.", shortNumber(worst->rms_px), worst->image);
  return canvas.drawn(std::move(figure));
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
  canvas.addCircle(middle, kRadius, "class=\"paper\"");
  for (const double degrees : {15, 30, 45, 60, 75}) {
    const double radius = kRadius * degrees / kDegPerRad / kMostRad;
    canvas.addCircle(middle, radius, "class=\"ring\"");
  }
  canvas.addLine(middle - Vector2d(kRadius, 0), middle + Vector2d(kRadius, 0), "class=\"grid\"");
  canvas.addLine(middle - Vector2d(0, kRadius), middle + Vector2d(0, kRadius), "class=\"grid\"");
  int num_tilted = 0;
  for (const ReportedView& view : data.views) {
    if (!isKnown(view.tilt)) continue;
    num_tilted += totalTilt(view.tilt) > kMostRad / 5 ? 1 : 0;
    canvas.addCircle(at(view.tilt), 4, "class=\"view\"");
  }
  for (const double degrees : {15, 30, 45, 60, 75}) {
    const double radius = kRadius * degrees / kDegPerRad / kMostRad;
    canvas.addText(middle + radius * Vector2d(0.4, -0.9165) + Vector2d(2, -2),
                   fmt::format("{:.0f}°", degrees), "start", "class=\"tick halo\"");
  }
  if (data.next_view) canvas.addPath(starPath(at(data.next_view->tilt), 9), "class=\"next\"");
  canvas.addText(middle + Vector2d(kRadius + 6, 4), "right nearer", "start", "class=\"axis\"");
  canvas.addText(middle + Vector2d(-kRadius - 6, 4), "left nearer", "end", "class=\"axis\"");
  canvas.addText(middle + Vector2d(0, -kRadius - 8), "upper side nearer", "middle", "class=\"axis\"");
  canvas.addText(middle + Vector2d(0, kRadius + 16), "lower side nearer", "middle", "class=\"axis\"");
  Legend legend = {{"dot view", "view"}};
  if (data.next_view) legend.emplace_back("star next", "suggested next view");
  canvas.addLegend({44, 316}, legend);
  Figure figure{.id = "tilts", .title = "How the board was tilted"};
  figure.reading =
      "Each dot is a view, placed towards the side of the board that was nearer to the camera; dots should "
      "lie on all sides between 20 and 50 degrees. Tilt counts from the pose in which this lens shows the "
      "board square: without distortion that is parallel to the image, and with it a few degrees off towards "
      "the border.";
  if (data.next_view) figure.reading += " The star is the next photograph.";
  figure.alt =
      fmt::format("{} of {} views are tilted by more than 15 degrees.", num_tilted, data.views.size());
  return canvas.drawn(std::move(figure));
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
  const PlotArea area{.box = {Vector2d(44, 24), Vector2d(430, 268)},
                      .low = {0, 0},
                      .high = {1.08 * farthest, std::min(92.0, 1.06 * most_tilt)}};
  FigureCanvas canvas(305);
  canvas.addAxes(area, "distance of the board, m", "tilt, degrees");
  const auto at = [&](double distance_m, const BoardTilt& tilt) {
    return area.at(distance_m, std::min(kDegPerRad * totalTilt(tilt), area.high.y()));
  };
  double nearest = farthest;
  for (const ReportedView& view : data.views) {
    if (!isKnown(view.tilt)) continue;
    nearest = std::min(nearest, view.distance_m);
    canvas.addCircle(at(view.distance_m, view.tilt), 4, "class=\"view\"");
  }
  Legend legend = {{"dot view", "view"}};
  if (data.next_view) {
    const ReportedNextView& next = *data.next_view;
    canvas.addPath(starPath(at(next.distance_m, next.tilt), 9), "class=\"next\"");
    legend.emplace_back("star next", "suggested next view");
  }
  canvas.addLegend({44, 305}, legend);
  Figure figure{.id = "distances", .title = "How far away the board was"};
  figure.reading = "Each dot is a view; a good set has near and far boards, and most of them tilted.";
  if (data.next_view) figure.reading += " The star is the next photograph.";
  figure.alt = fmt::format("Boards were {} to {} m away.", shortNumber(nearest), shortNumber(farthest));
  return canvas.drawn(std::move(figure));
}

Figure nextViewFigure(const CalibrationEvidence& data) {
  const ReportedNextView& next = *data.next_view;
  const Board& target = data.boards[next.board].target;
  const BoardInk ink = inkOf(target);
  Eigen::AlignedBox2d sheet = ink.extent;
  const Vector2d margin = Vector2d::Constant(0.35 * target.spacing());
  sheet.extend(sheet.min() - margin);
  sheet.extend(sheet.max() + margin);
  // The image and enough of its surroundings to show where the board continues.
  const Eigen::AlignedBox2d image(Vector2d(-0.5, -0.5),
                                  Vector2d(data.size.width - 0.5, data.size.height - 0.5));
  const Eigen::AlignedBox2d shown = shownPixels(data, next.camera_from_board, sheet, image);
  ImagePlot plot = imagePlot({.width = static_cast<int>(std::lround(shown.sizes().x())),
                              .height = static_cast<int>(std::lround(shown.sizes().y()))});
  plot.legend_top -= 12;  // no marks here
  PlotArea& area = plot.area;
  area.low = shown.min();
  area.high = shown.max();
  const Vector2d image_low = area.at(image.min());
  const Vector2d image_high = area.at(image.max());
  FigureCanvas canvas(plot.legend_top);
  canvas.addRect(image_low, image_high, "class=\"scene\"");
  canvas.addPath(seenCorners(data, area), "class=\"corners faint\"");
  canvas.addRaw("<clipPath id=\"next-clip\">");
  canvas.addRect(image_low, image_high, "");
  canvas.addRaw("</clipPath><clipPath id=\"next-ghost-clip\">");
  canvas.addRect(area.box.min(), area.box.max(), "");
  canvas.addRaw("</clipPath>\n<defs>");
  canvas.open("id=\"next-board\"");
  canvas.addPath(projectedSheet(data, next.camera_from_board, sheet, target.spacing(), area),
                 "class=\"sheet\"");
  canvas.addPath(projectedInk(data, next.camera_from_board, ink, area), "class=\"print\"");
  canvas.close();
  canvas.addRaw(
      "</defs>\n<use href=\"#next-board\" class=\"ghost\" clip-path=\"url(#next-ghost-clip)\"/><use "
      "href=\"#next-board\" clip-path=\"url(#next-clip)\"/>\n");
  canvas.addPath(projectedOutline(data, next.camera_from_board, sheet, 24, area),
                 "class=\"ghost-outline\" clip-path=\"url(#next-ghost-clip)\"");
  canvas.addRect(image_low, image_high, "class=\"frame strong-frame\"");
  addNearerSides(data, next, ink, area, canvas);
  const bool is_beyond = !image.contains(shown);
  Legend legend = {{"sheet", "the board in the next photograph"}, {"dot corner", "corners seen so far"}};
  if (is_beyond) legend.emplace_back("line ghost-outline", "the board beyond the image");
  canvas.addLegend({area.box.min().x(), plot.legend_top}, legend);
  Figure figure{.id = "next-view", .title = "The next photograph"};
  figure.reading =
      "This is what the camera should see: move the board until your picture looks like this one.";
  if (is_beyond)
    figure.reading += " A part of the board lies beyond the border of the image; that part is drawn pale.";
  figure.alt = "The suggested next photograph: " + next.text + ".";
  return canvas.drawn(std::move(figure));
}

std::string cornersPicture(const ReportData& data, const ReportedView& view) {
  constexpr double kPictureWidth = 160;
  const double scale = kPictureWidth / data.size.width;
  FigureCanvas canvas(scale * data.size.height, kPictureWidth);
  std::string dots;
  for (const ReportedCorner& corner : view.corners)
    dots += "M" + pointText(scale * (corner.pixel + Vector2d(0.5, 0.5))) + "h0";
  canvas.addPath(dots, "class=\"corners\"");
  return canvas.svg("");
}

}  // namespace alidade
