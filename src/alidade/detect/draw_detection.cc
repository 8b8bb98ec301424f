// SPDX-License-Identifier: MIT
#include "alidade/detect/draw_detection.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

namespace alidade {
namespace {

using Eigen::Vector2d;

const cv::Scalar kRed(230, 40, 40);
const cv::Scalar kGreen(30, 200, 60);
const cv::Scalar kLine(40, 150, 255);
const cv::Scalar kText(255, 220, 0);
const cv::Scalar kShadow(0, 0, 0);

// OpenCV draws at fractions of a pixel if it is given the number of fractional bits.
constexpr int kShift = 4;
cv::Point fixedPoint(const Vector2d& pixel) {
  constexpr double kOne = 1 << kShift;
  return {static_cast<int>(std::lround(pixel.x() * kOne)), static_cast<int>(std::lround(pixel.y() * kOne))};
}

void write(cv::Mat& canvas, const std::string& text, const Vector2d& at, double size,
           const cv::Scalar& color) {
  const cv::Point place(static_cast<int>(at.x()), static_cast<int>(at.y()));
  const int thickness = std::max(1, static_cast<int>(std::lround(2 * size)));
  cv::putText(canvas, text, place, cv::FONT_HERSHEY_SIMPLEX, size, kShadow, thickness + 2, cv::LINE_AA);
  cv::putText(canvas, text, place, cv::FONT_HERSHEY_SIMPLEX, size, color, thickness, cv::LINE_AA);
}

std::string summary(const Detection& detection, const Board& board) {
  const std::string_view reason = reasonCode(detection.reason);
  if (detection.hasCorners()) {
    return fmt::format("{}: {} {}, blur {:.2f} px, spacing {:.0f} px, tilt {:.0f} deg", reason,
                       detection.corners.size(), board.words().points, detection.measures.blur_px,
                       detection.measures.spacing_px, detection.measures.tilt_deg);
  }
  return fmt::format("{}{}{}", reason, detection.detail.empty() ? "" : ": ", detection.detail);
}

// Factor on the size of lines, circles and letters, relative to a usual image.
double scaleFor(const cv::Mat& canvas) {
  constexpr double kUsualSide = 1000;
  return std::max(0.6, std::max(canvas.cols, canvas.rows) / kUsualSide);
}

cv::Mat canvasOf(const GrayImage& image) {
  // OpenCV has no view of constant data; cvtColor does not write to its input.
  const cv::Mat gray(image.size.height, image.size.width, CV_8U,
                     const_cast<std::uint8_t*>(image.pixels.data()));
  cv::Mat canvas;
  cv::cvtColor(gray, canvas, cv::COLOR_GRAY2RGB);
  return canvas;
}

RasterImage rasterOf(const GrayImage& image, const cv::Mat& canvas) {
  return {.size = image.size,
          .num_channels = 3,
          .bytes = std::vector<std::uint8_t>(canvas.datastart, canvas.dataend)};
}

void drawCorners(cv::Mat& canvas, const Detection& detection, const Board& board) {
  const double scale = scaleFor(canvas);
  const int width = std::max(1, static_cast<int>(std::lround(scale)));
  std::vector<const Corner*> by_id(static_cast<std::size_t>(board.numCorners()), nullptr);
  for (const Corner& corner : detection.corners) by_id[static_cast<std::size_t>(corner.id)] = &corner;
  const auto cornerAt = [&](int column, int row) -> const Corner* {
    if (column < 0 || row < 0 || column >= board.columns() || row >= board.rows()) return nullptr;
    return by_id[static_cast<std::size_t>(row * board.columns() + column)];
  };
  for (const Corner& corner : detection.corners) {
    const int column = corner.id % board.columns();
    const int row = corner.id / board.columns();
    const Corner* right = cornerAt(column + 1, row);
    const Corner* below = cornerAt(column, row + 1);
    for (const Corner* next : {right, below}) {
      if (next == nullptr) continue;
      const bool is_axis = (next == right && row == 0) || (next == below && column == 0);
      const cv::Scalar& color = !is_axis ? kLine : next == right ? kRed : kGreen;
      cv::line(canvas, fixedPoint(corner.pixel), fixedPoint(next->pixel), color, is_axis ? 2 * width : width,
               cv::LINE_AA, kShift);
    }
  }
  for (const Corner& corner : detection.corners) {
    constexpr double kRadius = 4;
    const int radius = static_cast<int>(std::lround(scale * kRadius * (1 << kShift)));
    cv::circle(canvas, fixedPoint(corner.pixel), radius, corner.id == 0 ? kRed : kText, width, cv::LINE_AA,
               kShift);
    write(canvas, std::to_string(corner.id), corner.pixel + scale * Vector2d(4, -4), 0.35 * scale, kText);
  }
}

// Writes the text of line `line` from the top.
void writeSummary(cv::Mat& canvas, const Detection& detection, const Board& board, std::size_t line,
                  const std::string& label) {
  const double scale = scaleFor(canvas);
  constexpr double kLinePx = 20;
  write(canvas, label + summary(detection, board),
        scale * Vector2d(8, kLinePx * static_cast<double>(line + 1)), 0.5 * scale,
        detection.hasCorners() ? kGreen : kRed);
}

}  // namespace

RasterImage drawDetection(const GrayImage& image, const Detection& detection, const Board& board) {
  cv::Mat canvas = canvasOf(image);
  drawCorners(canvas, detection, board);
  writeSummary(canvas, detection, board, 0, "");
  return rasterOf(image, canvas);
}

RasterImage drawDetections(const GrayImage& image, std::span<const ImageOutcome> outcomes,
                           std::span<const Board> boards) {
  if (boards.size() == 1) return drawDetection(image, outcomes.front().detection, boards.front());
  cv::Mat canvas = canvasOf(image);
  for (std::size_t b = 0; b < boards.size(); ++b) drawCorners(canvas, outcomes[b].detection, boards[b]);
  for (std::size_t b = 0; b < boards.size(); ++b)
    writeSummary(canvas, outcomes[b].detection, boards[b], b, boards[b].spec() + ": ");
  return rasterOf(image, canvas);
}

}  // namespace alidade
