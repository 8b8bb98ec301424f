// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>

#include <Eigen/Core>

#include "alidade/imagery/output_view.h"

namespace alidade {

/// A rectangle of output pixels: columns [x, x + width) of rows [y, y + height).
struct Tile {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
};

/// The rays of an output image. A ray is made of a factor of its column and one of its row, so that a grid
/// needs sines and cosines along its two edges only. Rays are those of OutputView::rayFromPixel, to the bit.
class ViewRays {
 public:
  explicit ViewRays(const OutputView& view);

  /// The pixels that have a ray: a rectangle, empty if there are none.
  [[nodiscard]] const Tile& pixelsWithRay() const { return pixels_with_ray_; }

  struct Column {
    double x;
    double z;
  };
  struct Row {
    double height;
    double across;
  };
  /// The factors of places inside of that rectangle, between pixels too.
  [[nodiscard]] Column column(double x) const {
    const double plane = (x - view_.axis_px.x()) / view_.scale_px.x();
    if (view_.projection == ViewProjection::kRectilinear) return {plane, 1};
    return {std::sin(plane), std::cos(plane)};
  }
  [[nodiscard]] Row row(double y) const {
    const double plane = (y - view_.axis_px.y()) / view_.scale_px.y();
    if (view_.projection != ViewProjection::kEquirectangular) return {plane, 1};
    return {std::sin(plane), std::cos(plane)};
  }
  [[nodiscard]] static Eigen::Vector3d ray(const Column& column, const Row& row) {
    return {row.across * column.x, row.height, row.across * column.z};
  }

  /// How far off the optical axis the rays of a tile's area lie, between the centres of its outer pixels.
  struct AxisRange {
    double min_cos = 1;
    double max_cos = -1;
    Eigen::Vector2d farthest = Eigen::Vector2d::Zero();  ///< the pixel coordinates of min_cos
    Eigen::Vector2d nearest = Eigen::Vector2d::Zero();   ///< and those of max_cos
  };
  [[nodiscard]] AxisRange axisRange(const Tile& tile) const;

 private:
  const OutputView& view_;
  Tile pixels_with_ray_;
};

}  // namespace alidade
