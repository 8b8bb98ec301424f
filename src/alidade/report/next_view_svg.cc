// SPDX-License-Identifier: MIT
#include "alidade/report/next_view_svg.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "alidade/camera/projection_uncertainty.h"
#include "alidade/validate/coverage.h"

namespace alidade {
namespace {

constexpr double kMarked = 0.087;  // tilts from 5 degrees on have a side that is marked, as in tiltText()

// Colours from certain to uncertain, pale enough for lines on top.
std::string colourAt(double share) {
  constexpr std::array<std::array<double, 3>, 3> kRamp = {{{232, 244, 250}, {254, 232, 168}, {240, 128, 92}}};
  const double at = 2 * std::clamp(share, 0.0, 1.0);
  const std::size_t low = at < 1 ? 0 : 1;
  const double t = at - static_cast<double>(low);
  std::array<int, 3> rgb{};
  for (std::size_t c = 0; c < 3; ++c)
    rgb[c] = static_cast<int>(std::lround((1 - t) * kRamp[low][c] + t * kRamp[low + 1][c]));
  return fmt::format("#{:02x}{:02x}{:02x}", rgb[0], rgb[1], rgb[2]);
}

class Drawing {
 public:
  explicit Drawing(ImageSize size)
      : size_(size),
        unit_(std::max(size.width, size.height) / 100.0),
        margin_(10 * unit_),
        low_(size.height + margin_) {}

  // The share of the scale goes with the logarithm: uncertainty grows steeply towards the image's corners.
  void addMap(const UncertaintyGrid& grid, double inflation) {
    double least = std::numeric_limits<double>::infinity();
    for (const double std : grid.std_px) {
      if (std > 0) least = std::min(least, std);  // false for NaN
    }
    if (!(least < grid.worst_px)) return;
    const double range = std::log(grid.worst_px / least);
    const double width = static_cast<double>(size_.width) / (grid.columns - 1);
    const double height = static_cast<double>(size_.height) / std::max(1, grid.rows - 1);
    svg_ += "<g stroke=\"none\">\n";
    for (std::size_t i = 0; i < grid.pixels.size(); ++i) {
      if (!std::isfinite(grid.std_px[i])) continue;
      const Eigen::Vector2d low = (grid.pixels[i] - 0.5 * Eigen::Vector2d(width, height)).cwiseMax(-0.5);
      const Eigen::Vector2d high = (grid.pixels[i] + 0.5 * Eigen::Vector2d(width, height))
                                       .cwiseMin(Eigen::Vector2d(size_.width - 0.5, size_.height - 0.5));
      svg_ +=
          fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"{}\"/>\n",
                      low.x(), low.y(), high.x() - low.x(), high.y() - low.y(),
                      colourAt(std::log(grid.std_px[i] / least) / range));
    }
    svg_ += "</g>\n";
    addLegend(inflation * least, inflation * grid.worst_px);
  }

  void addFrame() {
    svg_ += fmt::format(
        "<rect x=\"-0.5\" y=\"-0.5\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"#333\" "
        "stroke-width=\"{:.2f}\"/>\n",
        size_.width, size_.height, 0.25 * unit_);
  }

  void addDots(const std::vector<Eigen::Vector2d>& pixels, const char* colour, double radius) {
    svg_ += fmt::format("<g fill=\"{}\">\n", colour);
    for (const Eigen::Vector2d& pixel : pixels)
      svg_ += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:.2f}\"/>\n", pixel.x(), pixel.y(),
                          radius * unit_);
    svg_ += "</g>\n";
  }

  void addLine(const std::vector<Eigen::Vector2d>& pixels, const char* colour, double width) {
    if (pixels.size() < 2) return;
    svg_ += fmt::format("<polyline fill=\"none\" stroke=\"{}\" stroke-width=\"{:.2f}\" points=\"", colour,
                        width * unit_);
    for (const Eigen::Vector2d& pixel : pixels) svg_ += fmt::format("{:.1f},{:.1f} ", pixel.x(), pixel.y());
    svg_ += "\"/>\n";
  }

  void addLabel(const Eigen::Vector2d& at, const char* colour, const std::string& text,
                const char* anchor = "middle") {
    svg_ += fmt::format(
        "<text x=\"{:.1f}\" y=\"{:.1f}\" fill=\"{}\" text-anchor=\"{}\" paint-order=\"stroke\" "
        "stroke=\"white\" stroke-width=\"{:.2f}\">{}</text>\n",
        at.x(), at.y(), colour, anchor, 0.5 * unit_, text);
  }

  // Lines of text under what is drawn so far, broken where they get too long.
  void addCaption(const std::string& text) {
    constexpr std::size_t kLineChars = 88;
    std::string line;
    const auto flush = [&] {
      if (line.empty()) return;
      low_ += 2.6 * unit_;
      addLabel({0, low_}, "#111", line, "start");
      line.clear();
    };
    std::string word;
    for (const char c : text) {
      if (c != ' ' && c != '\n') {
        word += c;
        continue;
      }
      if (line.size() + word.size() > kLineChars) flush();
      line += (line.empty() ? "" : " ") + word;
      word.clear();
      if (c == '\n') flush();
    }
    flush();
  }

  [[nodiscard]] double unit() const { return unit_; }
  // The nearest place at which a word can be read as a whole.
  [[nodiscard]] Eigen::Vector2d inside(const Eigen::Vector2d& at) const {
    const double edge = margin_ - 4 * unit_;
    return {std::clamp(at.x(), -edge, size_.width + edge), std::clamp(at.y(), -edge, size_.height + edge)};
  }
  [[nodiscard]] std::string text() const {
    return fmt::format(
               "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"900\" viewBox=\"{0:.1f} {0:.1f} {1:.1f} "
               "{2:.1f}\" font-family=\"sans-serif\" font-size=\"{3:.2f}\">\n<rect x=\"{0:.1f}\" "
               "y=\"{0:.1f}\" width=\"{1:.1f}\" height=\"{2:.1f}\" fill=\"white\"/>\n",
               -margin_, size_.width + 2 * margin_, low_ + margin_ + 2 * unit_, 2.2 * unit_) +
           svg_ + "</svg>\n";
  }

 private:
  void addLegend(double least_px, double worst_px) {
    constexpr int kSteps = 24;
    const double top = low_ + unit_;
    low_ += 3 * unit_;
    const double step = 1.25 * unit_;
    for (int i = 0; i < kSteps; ++i) {
      svg_ +=
          fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"{}\"/>\n",
                      8 * unit_ + i * step, top, 1.05 * step, 2 * unit_, colourAt(i / (kSteps - 1.0)));
    }
    const double base = top + 1.7 * unit_;
    addLabel({7 * unit_, base}, "#111", fmt::format("{:.2g} px", least_px), "end");
    addLabel({9 * unit_ + kSteps * step, base}, "#111",
             fmt::format("{:.2g} px uncertain (one sigma)", worst_px), "start");
  }

  ImageSize size_;
  double unit_;    // a hundredth of the longer side
  double margin_;  // around the image, for a board that sticks out of it
  double low_;     // where the caption goes on
  std::string svg_;
};

struct BoardSide {
  std::vector<Eigen::Vector2d> pixels;
  Eigen::Vector2d middle{0, 0};
};

// The four sides of the squares, as far as the camera shows them.
std::vector<BoardSide> boardSides(const AnyCamera& camera, const Checkerboard& board,
                                  const SE3& camera_from_board) {
  const double right = board.columns;
  const double low = board.rows;
  const std::array<std::array<double, 4>, 4> ends = {
      {{-1, -1, right, -1}, {right, -1, right, low}, {right, low, -1, low}, {-1, low, -1, -1}}};
  std::vector<BoardSide> sides;
  for (const auto& end : ends) {
    constexpr int kSteps = 24;
    BoardSide side;
    for (int i = 0; i <= kSteps; ++i) {
      const double t = static_cast<double>(i) / kSteps;
      const Eigen::Vector3d point(board.square_m * ((1 - t) * end[0] + t * end[2]),
                                  board.square_m * ((1 - t) * end[1] + t * end[3]), 0);
      const Projection projection = camera.project(camera_from_board * point);
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

void addNextView(const CalibrationResult& result, const Checkerboard& board, const NextView& next,
                 Drawing& drawing) {
  const std::vector<BoardSide> sides = boardSides(result.camera, board, next.camera_from_board);
  for (const BoardSide& side : sides) drawing.addLine(side.pixels, "#0b5d1e", 0.4);
  std::vector<Eigen::Vector2d> corners;
  for (const Eigen::Vector3d& point : cornerPositions(board)) {
    const Projection projection = result.camera.project(next.camera_from_board * point);
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

std::string nextViewSvg(const CalibrationResult& result, const Checkerboard& board,
                        std::span<const View> views, const Guidance& guidance) {
  Drawing drawing(result.image_size);
  if (guidance.is_determined && result.covariance) {
    const ProjectionUncertainty uncertainty(result.camera, result.image_size,
                                            std::numeric_limits<double>::infinity());
    drawing.addMap(uncertainty.grid(*result.covariance), guidance.inflation);
  }
  drawing.addFrame();
  for (const auto& corners : usedCorners(result, views)) drawing.addDots(corners, "#34568b", 0.25);
  if (guidance.next) addNextView(result, board, *guidance.next, drawing);
  drawing.addCaption("Next: " + nextViewText(guidance, result.image_size));
  return drawing.text();
}

}  // namespace alidade
