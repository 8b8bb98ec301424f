// SPDX-License-Identifier: MIT
#include "alidade/report/figures/next_view_svg.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "alidade/camera/projection_uncertainty.h"
#include "alidade/guide/coverage.h"
#include "alidade/report/canvas/figure_canvas.h"

namespace alidade {
namespace {

using Eigen::Vector2d;

constexpr double kMarked = 0.087;  // sides are marked for tilts from 5 degrees, as in tiltText()

// Colours are logarithmic, because uncertainty rises steeply towards the image's corners.
void addMap(const UncertaintyGrid& grid, double inflation, const ImageSize& size, FigureCanvas& canvas) {
  double least = std::numeric_limits<double>::infinity();
  for (const double std : grid.std_px) {
    if (std > 0) least = std::min(least, std);  // false for NaN
  }
  if (!(least < grid.worst_px)) return;
  const double range = std::log(grid.worst_px / least);
  const Vector2d half(0.5 * size.width / (grid.columns - 1), 0.5 * size.height / std::max(1, grid.rows - 1));
  const Vector2d border(size.width - 0.5, size.height - 0.5);
  canvas.open("shape-rendering=\"crispEdges\"");
  for (std::size_t i = 0; i < grid.pixels.size(); ++i) {
    if (!std::isfinite(grid.std_px[i])) continue;
    const Vector2d low = (grid.pixels[i] - half).cwiseMax(-0.5);
    const Vector2d high = (grid.pixels[i] + half).cwiseMin(border);
    canvas.addRect(canvas.at(low), canvas.at(high),
                   fmt::format("fill=\"{}\"", rampColour(std::log(grid.std_px[i] / least) / range)));
  }
  canvas.close();
  canvas.addRamp(
      fmt::format("{:.2g} px", inflation * least),
      fmt::format("{:.2g} px projection uncertainty (one standard deviation)", inflation * grid.worst_px));
}

// Pixels along the visible parts of the four sides of the squares.
std::vector<std::vector<Vector2d>> boardSides(const AnyCamera& camera, const Board& board,
                                              const SE3& camera_from_board) {
  const std::vector<Vector2d> corners = cornersOf(board.printed());
  std::vector<std::vector<Vector2d>> sides;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    constexpr int kSteps = 24;
    std::vector<Vector2d> side;
    for (int i = 0; i <= kSteps; ++i) {
      const double t = static_cast<double>(i) / kSteps;
      const Vector2d point = (1 - t) * corners[k] + t * corners[(k + 1) % corners.size()];
      const Projection projection =
          camera.projectPoint(camera_from_board * Eigen::Vector3d(point.x(), point.y(), 0));
      if (projection.ok()) side.push_back(projection.pixel);
    }
    if (!side.empty()) sides.push_back(std::move(side));
  }
  return sides;
}

Vector2d meanOf(const std::vector<Vector2d>& pixels) {
  Vector2d sum(0, 0);
  for (const Vector2d& pixel : pixels) sum += pixel;
  return sum / static_cast<double>(pixels.size());
}

void addDots(const std::vector<Vector2d>& pixels, double radius, const char* attributes,
             FigureCanvas& canvas) {
  canvas.open(attributes);
  for (const Vector2d& pixel : pixels) canvas.addCircle(canvas.at(pixel), radius, "");
  canvas.close();
}

void addNextView(const AnyCamera& camera, const Board& board, const NextView& next, FigureCanvas& canvas) {
  const auto sides = boardSides(camera, board, next.camera_from_board);
  for (const auto& side : sides)
    canvas.addPath(pathThrough(canvas.at(side)), "stroke=\"#0b5d1e\" stroke-width=\"2\"");
  std::vector<Vector2d> corners;
  for (const Eigen::Vector3d& point : board.corners()) {
    const Projection projection = camera.projectPoint(next.camera_from_board * point);
    if (projection.ok()) corners.push_back(projection.pixel);
  }
  addDots(corners, 2.2, "fill=\"#0b5d1e\"", canvas);
  const auto mark = [&](const Vector2d& direction) {
    const auto side = std::ranges::max_element(
        sides, {}, [&](const auto& pixels) { return meanOf(pixels).dot(direction); });
    if (side == sides.end()) return;
    canvas.addPath(pathThrough(canvas.at(*side)), "nearer");
    constexpr double kEdge = 24;  // so that the whole label is readable
    const Vector2d place = (canvas.at(meanOf(*side)) + 18 * direction)
                               .cwiseMax(Vector2d(kEdge, 12))
                               .cwiseMin(Vector2d(canvas.width() - kEdge, canvas.area().box.max().y() - 4));
    canvas.addText(place, "nearer", "middle", "nearer-words halo");
  };
  const BoardTilt& tilt = next.sighting.tilt;
  if (std::abs(tilt.right_rad) > kMarked) mark({tilt.right_rad > 0 ? 1 : -1, 0});
  if (std::abs(tilt.lower_rad) > kMarked) mark({0, tilt.lower_rad > 0 ? 1 : -1});
}

// The image with a margin for a board that extends beyond it.
PlotArea areaAround(const ImageSize& size) {
  const int margin = std::max(size.width, size.height) / 10;
  PlotArea area = imageArea({.width = size.width + 2 * margin, .height = size.height + 2 * margin},
                            FigureCanvas::kFileWidth);
  area.low -= Vector2d::Constant(margin);
  area.high -= Vector2d::Constant(margin);
  return area;
}

}  // namespace

std::string nextViewSvg(const Calibration& calibration, std::span<const View> views,
                        const Guidance& guidance) {
  const AnyCamera camera = calibration.camera();
  const ImageSize size = calibration.imageSize();
  FigureCanvas canvas(areaAround(size), 6, FigureCanvas::kFileWidth);
  if (guidance.is_determined && calibration.uncertainty.covariance) {
    const ProjectionUncertainty uncertainty(camera, size, std::numeric_limits<double>::infinity());
    addMap(uncertainty.grid(*calibration.uncertainty.covariance), guidance.inflation, size, canvas);
  }
  canvas.addRect(canvas.at(-0.5, -0.5), canvas.at(size.width - 0.5, size.height - 0.5), "frame");
  for (const auto& corners : usedCorners(calibration, views))
    addDots(corners, 1.4, "fill=\"#34568b\"", canvas);
  if (guidance.next) addNextView(camera, guidance.board, *guidance.next, canvas);
  const std::string words = "Next: " + nextViewText(guidance, size);
  canvas.addCaption(words);
  return standaloneSvg(canvas.svg(words));
}

}  // namespace alidade
