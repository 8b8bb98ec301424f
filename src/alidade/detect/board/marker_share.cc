// SPDX-License-Identifier: MIT
#include "alidade/detect/board/marker_share.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "alidade/detect/corner/grey_at.h"

namespace alidade {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Homography from the unit square to the image.
Eigen::Matrix3d homographyOf(const std::array<Vector2d, 4>& c) {
  const Vector2d bend = c[0] - c[1] + c[2] - c[3];
  Eigen::Matrix2d sides;
  sides << c[1] - c[2], c[3] - c[2];
  const Vector2d g = sides.inverse() * bend;
  Eigen::Matrix3d h;
  h << c[1].x() - c[0].x() + g(0) * c[1].x(), c[3].x() - c[0].x() + g(1) * c[3].x(), c[0].x(),
      c[1].y() - c[0].y() + g(0) * c[1].y(), c[3].y() - c[0].y() + g(1) * c[3].y(), c[0].y(), g(0), g(1), 1;
  return h;
}

// Distance from a side of the square, up to `depth`, at which the mean grey value along the side is midway
// between the brightest place and the darkest one behind it. Nothing if there is no contrast, or if the
// square extends beyond the image.
std::optional<double> edgeDepth(const GrayImage& image, const Eigen::Matrix3d& h, double depth,
                                double half_length) {
  constexpr int kNumSteps = 64;
  constexpr int kNumLines = 9;
  constexpr double kLeastContrast = 20;
  std::array<double, kNumSteps + 1> values{};
  for (int i = 0; i <= kNumSteps; ++i) {
    double sum = 0;
    for (int line = 0; line < kNumLines; ++line) {
      const double along = 0.5 + half_length * (2.0 * line / (kNumLines - 1) - 1);
      const Vector3d p = h * Vector3d(along, i * (depth / kNumSteps), 1);
      const auto grey = greyAt(image, p.head<2>() / p.z());
      if (!grey) return std::nullopt;
      sum += *grey;
    }
    values[static_cast<std::size_t>(i)] = sum / kNumLines;
  }
  auto* const end = values.end();
  auto* const brightest = std::ranges::max_element(values);
  auto* const darkest = std::min_element(brightest, end);
  if (*brightest - *darkest < kLeastContrast) return std::nullopt;
  const double midway = 0.5 * (*brightest + *darkest);
  auto* const below = std::find_if(brightest, end, [&](double v) { return v < midway; });
  const double rest = (midway - *below) / (*(below - 1) - *below);
  return depth / kNumSteps * (static_cast<double>(below - values.begin()) - rest);
}

}  // namespace

std::optional<double> measuredMarkerShare(const GrayImage& image, const std::array<Vector2d, 4>& square,
                                          double expected, int num_cells) {
  constexpr double kLeastMarginPx = 3;  // in narrower margins, the edges of the corners blur into each other
  const double margin = 0.5 * (1 - expected);
  const double cell = expected / num_cells;
  double shortest_px = (square[0] - square[3]).norm();
  for (std::size_t k = 0; k < 3; ++k) shortest_px = std::min(shortest_px, (square[k + 1] - square[k]).norm());
  if (!(margin * shortest_px >= kLeastMarginPx)) return std::nullopt;
  double sum = 0;
  std::array<Vector2d, 4> turned = square;
  for (int side = 0; side < 4; ++side) {
    const auto at = edgeDepth(image, homographyOf(turned), margin + 0.6 * cell, 0.5 * expected - cell);
    if (!at) return std::nullopt;
    sum += *at;
    std::rotate(turned.begin(), turned.begin() + 1, turned.end());
  }
  return 1 - 0.5 * sum;
}

}  // namespace alidade
