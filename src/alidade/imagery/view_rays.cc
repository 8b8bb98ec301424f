// SPDX-License-Identifier: MIT
#include "alidade/imagery/view_rays.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

namespace alidade {
namespace {

// The first of `count` indices for which `has_ray` holds, and how many follow it without a gap.
template <class HasRay>
std::pair<int, int> firstRun(int count, const HasRay& has_ray) {
  int first = 0;
  while (first < count && !has_ray(first)) ++first;
  int end = first;
  while (end < count && has_ray(end)) ++end;
  return {first, end - first};
}

}  // namespace

ViewRays::ViewRays(const OutputView& view) : view_(view) {
  // A plane is bounded along each coordinate by itself, so that the centre of the other one stands for all.
  const auto has_column = [&](int x) {
    return rayFromPlane(view.projection, {view.planeFromPixel({x, 0}).x(), 0}).has_value();
  };
  const auto has_row = [&](int y) {
    return rayFromPlane(view.projection, {0, view.planeFromPixel({0, y}).y()}).has_value();
  };
  std::tie(pixels_with_ray_.x, pixels_with_ray_.width) = firstRun(view.size.width, has_column);
  std::tie(pixels_with_ray_.y, pixels_with_ray_.height) = firstRun(view.size.height, has_row);
}

ViewRays::AxisRange ViewRays::axisRange(const Tile& tile) const {
  const double left = tile.x;
  const double right = tile.x + tile.width - 1;
  const double top = tile.y;
  const double bottom = tile.y + tile.height - 1;
  const double middle = std::clamp(view_.axis_px.x(), left, right);
  AxisRange range;
  // In all projections the cosine falls with the distance |x| from the axis at each y. At each x it is
  // monotone in |y|: falling in front of the camera, rising behind it.
  for (const double y : {top, bottom, std::clamp(view_.axis_px.y(), top, bottom)}) {
    const Row row = this->row(y);
    for (const double x : {left, right, middle}) {
      const Eigen::Vector3d r = ray(column(x), row);
      const double cosine = r.z() / r.norm();
      // Where lengths overflow nothing is known of the tile.
      if (!std::isfinite(cosine)) return {.min_cos = -1, .max_cos = 1};
      if (cosine <= range.min_cos) {
        range.min_cos = cosine;
        range.farthest = {x, y};
      }
      if (cosine >= range.max_cos) {
        range.max_cos = cosine;
        range.nearest = {x, y};
      }
    }
  }
  return range;
}

}  // namespace alidade
