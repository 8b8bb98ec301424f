// SPDX-License-Identifier: MIT
#include "alidade/detect/corner/edge_window.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/LU>

namespace alidade {
namespace {

// Tells whether places, relative to the origin, are in the window.
class WindowTest {
 public:
  WindowTest(const EdgeWindow& window, const Eigen::Vector2i& origin) {
    Eigen::Matrix2d steps;
    steps << window.step_u, window.step_v;
    shares_ = steps.inverse();
    shares_.row(0) /= window.reach_u;
    shares_.row(1) /= window.reach_v;
    center_ = shares_ * (window.center - origin.cast<double>());
  }

  [[nodiscard]] bool contains(double x, double y) const {
    return std::abs(shares_(0, 0) * x + shares_(0, 1) * y - center_.x()) <= 1 &&
           std::abs(shares_(1, 0) * x + shares_(1, 1) * y - center_.y()) <= 1;
  }

 private:
  Eigen::Matrix2d shares_;
  Eigen::Vector2d center_;
};

// Pixels of the window's bounding box that are in the image, relative to the origin; empty if last < first.
struct PixelRange {
  int first = 0;
  int last = -1;
};

struct PixelBox {
  PixelRange x;
  PixelRange y;
};

PixelBox boxOf(const GrayImage& image, const EdgeWindow& window, const Eigen::Vector2i& origin) {
  const Eigen::Vector2d half =
      window.reach_u * window.step_u.cwiseAbs() + window.reach_v * window.step_v.cwiseAbs();
  const Eigen::Vector2d low = window.center - half;
  const Eigen::Vector2d high = window.center + half;
  const auto rangeOf = [](double from, double to, int size, int at) {
    return PixelRange{.first = static_cast<int>(std::ceil(std::clamp(from, 0.0, size + 1.0))) - at,
                      .last = static_cast<int>(std::floor(std::clamp(to, -1.0, size - 1.0))) - at};
  };
  return {.x = rangeOf(low.x(), high.x(), image.size.width, origin.x()),
          .y = rangeOf(low.y(), high.y(), image.size.height, origin.y())};
}

struct Line {
  Line(const EdgeModel& model, std::size_t line, double blur_reach)
      : corner(model.corner()),
        direction(model.direction(line)),
        normal(model.normal(line)),
        curvature(model[EdgeModel::kCurvature1 + line]),
        half_width(blur_reach * model[EdgeModel::kBlur1 + line] + 0.5) {}

  [[nodiscard]] bool isNear(double x, double y) const {
    const double dx = x - corner.x();
    const double dy = y - corner.y();
    const double u = dx * direction.x() + dy * direction.y();
    const double v = dx * normal.x() + dy * normal.y();
    return std::abs(v - 0.5 * curvature * u * u) <= half_width;
  }

  Eigen::Vector2d corner;
  Eigen::Vector2d direction;
  Eigen::Vector2d normal;
  double curvature;
  double half_width;
};

}  // namespace

void gatherLattice(const GrayImage& image, const EdgeWindow& window, const Eigen::Vector2i& origin,
                   int stride, EdgePixels& pixels) {
  pixels.clear();
  const WindowTest test(window, origin);
  const PixelBox box = boxOf(image, window, origin);
  // Each row starts elsewhere: an edge along the columns would otherwise fall between the same two samples in
  // all.
  const int shift = std::max(1, static_cast<int>(std::lround(0.38 * stride)));
  int start = 0;
  for (int y = box.y.first; y <= box.y.last; y += stride) {
    for (int x = box.x.first + start; x <= box.x.last; x += stride) {
      if (test.contains(x, y)) {
        pixels.push(static_cast<float>(x), static_cast<float>(y), image.at(x + origin.x(), y + origin.y()));
      }
    }
    start = (start + shift) % stride;
  }
}

void gatherBands(const GrayImage& image, const EdgeWindow& window, const Eigen::Vector2i& origin,
                 const EdgeModel& model, double blur_reach, EdgePixels& pixels) {
  pixels.clear();
  const WindowTest test(window, origin);
  const PixelBox box = boxOf(image, window, origin);
  const std::array<Line, 2> lines = {Line(model, 0, blur_reach), Line(model, 1, blur_reach)};
  for (std::size_t i = 0; i < 2; ++i) {
    const Line& line = lines[i];
    // Steps along the image axis the line runs along more, and takes the pixels about it on the other one.
    const int along = std::abs(line.direction.x()) >= std::abs(line.direction.y()) ? 0 : 1;
    const int across = 1 - along;
    const PixelRange& outer = along == 0 ? box.x : box.y;
    const PixelRange& inner = along == 0 ? box.y : box.x;
    const double slope = line.direction[across] / line.direction[along];
    // A pixel more for the curve, which is not followed exactly here: isNear() decides.
    const double half = line.half_width / std::abs(line.direction[along]) + 1;
    for (int p = outer.first; p <= outer.last; ++p) {
      const double off = p - line.corner[along];
      const double u = off / line.direction[along];
      const double middle =
          line.corner[across] + slope * off + 0.5 * line.curvature * u * u / line.normal[across];
      if (!(std::abs(middle) < 1e6)) continue;
      const int first = std::max(inner.first, static_cast<int>(std::ceil(middle - half)));
      const int last = std::min(inner.last, static_cast<int>(std::floor(middle + half)));
      for (int q = first; q <= last; ++q) {
        const int x = along == 0 ? p : q;
        const int y = along == 0 ? q : p;
        if (!line.isNear(x, y) || !test.contains(x, y) || (i == 1 && lines[0].isNear(x, y))) continue;
        pixels.push(static_cast<float>(x), static_cast<float>(y), image.at(x + origin.x(), y + origin.y()));
      }
    }
  }
}

}  // namespace alidade
