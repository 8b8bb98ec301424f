// SPDX-License-Identifier: MIT
#include "alidade/calibrate/uncertainty/covered_pixels.h"
#include "alidade/core/mapped.h"

#include <algorithm>
#include <cstddef>

namespace alidade {
namespace {

using Polygon = std::vector<Eigen::Vector2d>;

// Twice the area of the triangle, positive if c is to the left of the line from a to b (y up).
double turn(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  const Eigen::Vector2d ab = b - a;
  const Eigen::Vector2d ac = c - a;
  return ab.x() * ac.y() - ab.y() * ac.x();
}

// One side of the hull of points in order of x: removes each point that the next one passes on the wrong
// side.
void addChain(const Polygon& points, Polygon& hull) {
  const std::size_t first = hull.size();
  for (const Eigen::Vector2d& point : points) {
    while (hull.size() >= first + 2 && turn(hull[hull.size() - 2], hull.back(), point) <= 0) hull.pop_back();
    hull.push_back(point);
  }
  hull.pop_back();  // the other side starts there
}

// Andrew 1979, Another efficient algorithm for convex hulls in two dimensions.
Polygon hullOf(const View& view) {
  Polygon points;
  for (const Corner& corner : view.corners) points.push_back(corner.pixel);
  std::sort(points.begin(), points.end(), [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
  });
  Polygon hull;
  if (points.size() < 3) return hull;
  addChain(points, hull);
  std::reverse(points.begin(), points.end());
  addChain(points, hull);
  return hull;
}

bool isInside(const Polygon& hull, const Eigen::Vector2d& pixel) {
  if (hull.size() < 3) return false;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    if (turn(hull[i], hull[(i + 1) % hull.size()], pixel) < 0) return false;
  }
  return true;
}

}  // namespace

std::vector<bool> isCovered(std::span<const Eigen::Vector2d> pixels, std::span<const View> views) {
  const std::vector<Polygon> hulls = mapped(views, hullOf);
  return mapped(pixels, [&](const Eigen::Vector2d& pixel) {
    return std::any_of(hulls.begin(), hulls.end(),
                       [&](const Polygon& hull) { return isInside(hull, pixel); });
  });
}

std::vector<Eigen::Vector2d> coveredPixels(std::span<const Eigen::Vector2d> pixels,
                                           std::span<const View> views) {
  const std::vector<bool> is_covered = isCovered(pixels, views);
  std::vector<Eigen::Vector2d> covered;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    if (is_covered[i]) covered.push_back(pixels[i]);
  }
  return covered;
}

}  // namespace alidade
