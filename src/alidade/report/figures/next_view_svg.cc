// SPDX-License-Identifier: MIT
#include "alidade/report/figures/next_view_svg.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "alidade/camera/projection_uncertainty.h"
#include "alidade/guide/coverage.h"
#include "alidade/report/canvas/svg_canvas.h"

namespace alidade {
namespace {

constexpr double kMarked = 0.087;  // tilts from 5 degrees on have a side that is marked, as in tiltText()

// The share of the scale goes with the logarithm: uncertainty grows steeply towards the image's corners.
void addMap(const UncertaintyGrid& grid, double inflation, SvgCanvas& drawing) {
  double least = std::numeric_limits<double>::infinity();
  for (const double std : grid.std_px) {
    if (std > 0) least = std::min(least, std);  // false for NaN
  }
  if (!(least < grid.worst_px)) return;
  const double range = std::log(grid.worst_px / least);
  const ImageSize size = drawing.size();
  const Eigen::Vector2d half(0.5 * size.width / (grid.columns - 1),
                             0.5 * size.height / std::max(1, grid.rows - 1));
  drawing.addText("<g stroke=\"none\">\n");
  for (std::size_t i = 0; i < grid.pixels.size(); ++i) {
    if (!std::isfinite(grid.std_px[i])) continue;
    drawing.addRect((grid.pixels[i] - half).cwiseMax(-0.5),
                    (grid.pixels[i] + half).cwiseMin(Eigen::Vector2d(size.width - 0.5, size.height - 0.5)),
                    rampColour(std::log(grid.std_px[i] / least) / range));
  }
  drawing.addText("</g>\n");
  drawing.addRamp(
      drawing.takeRow(3) + drawing.unit(), fmt::format("{:.2g} px", inflation * least),
      fmt::format("{:.2g} px projection uncertainty (one standard deviation)", inflation * grid.worst_px));
}

struct BoardSide {
  std::vector<Eigen::Vector2d> pixels;
  Eigen::Vector2d middle{0, 0};
};

// The four sides of the squares, as far as the camera shows them.
std::vector<BoardSide> boardSides(const AnyCamera& camera, const Board& board, const SE3& camera_from_board) {
  const auto corner = [&](Eigen::AlignedBox2d::CornerType which) { return board.printed().corner(which); };
  const std::array<Eigen::Vector2d, 4> corners = {
      corner(Eigen::AlignedBox2d::BottomLeft), corner(Eigen::AlignedBox2d::BottomRight),
      corner(Eigen::AlignedBox2d::TopRight), corner(Eigen::AlignedBox2d::TopLeft)};
  std::vector<BoardSide> sides;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    constexpr int kSteps = 24;
    BoardSide side;
    for (int i = 0; i <= kSteps; ++i) {
      const double t = static_cast<double>(i) / kSteps;
      const Eigen::Vector2d point = (1 - t) * corners[k] + t * corners[(k + 1) % corners.size()];
      const Projection projection =
          camera.project(camera_from_board * Eigen::Vector3d(point.x(), point.y(), 0));
      if (!projection.ok()) continue;
      side.pixels.push_back(projection.pixel);
      side.middle += projection.pixel;
    }
    if (side.pixels.empty()) continue;
    side.middle /= static_cast<double>(side.pixels.size());
    sides.push_back(std::move(side));
  }
  return sides;
}

void addNextView(const AnyCamera& camera, const Board& board, const NextView& next, SvgCanvas& drawing) {
  const std::vector<BoardSide> sides = boardSides(camera, board, next.camera_from_board);
  for (const BoardSide& side : sides) drawing.addLine(side.pixels, "#0b5d1e", 0.4);
  std::vector<Eigen::Vector2d> corners;
  for (const Eigen::Vector3d& point : board.corners()) {
    const Projection projection = camera.project(next.camera_from_board * point);
    if (projection.ok()) corners.push_back(projection.pixel);
  }
  drawing.addDots(corners, "#0b5d1e", 0.4);
  const auto mark = [&](const Eigen::Vector2d& direction) {
    const auto side = std::max_element(sides.begin(), sides.end(), [&](const auto& a, const auto& b) {
      return a.middle.dot(direction) < b.middle.dot(direction);
    });
    if (side == sides.end()) return;
    drawing.addLine(side->pixels, "#b3001b", 1);
    drawing.addLabel(drawing.inside(side->middle + 3 * drawing.unit() * direction), "#b3001b", "nearer");
  };
  const BoardTilt& tilt = next.sighting.tilt;
  if (std::abs(tilt.right_rad) > kMarked) mark({tilt.right_rad > 0 ? 1 : -1, 0});
  if (std::abs(tilt.lower_rad) > kMarked) mark({0, tilt.lower_rad > 0 ? 1 : -1});
}

}  // namespace

std::string nextViewSvg(const Calibration& calibration, std::span<const View> views,
                        const Guidance& guidance) {
  constexpr double kMargin = 10;  // for a board that sticks out of the image
  const AnyCamera camera = calibration.camera();
  const ImageSize size = calibration.imageSize();
  SvgCanvas drawing(size, kMargin);
  if (guidance.is_determined && calibration.uncertainty.covariance) {
    const ProjectionUncertainty uncertainty(camera, size, std::numeric_limits<double>::infinity());
    addMap(uncertainty.grid(*calibration.uncertainty.covariance), guidance.inflation, drawing);
  }
  drawing.addFrame();
  for (const auto& corners : usedCorners(calibration, views)) drawing.addDots(corners, "#34568b", 0.25);
  if (guidance.next) addNextView(camera, guidance.board, *guidance.next, drawing);
  drawing.addCaption("Next: " + nextViewText(guidance, size));
  return drawing.text();
}

}  // namespace alidade
