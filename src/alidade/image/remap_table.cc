// SPDX-License-Identifier: MIT
#include "alidade/image/remap_table.h"

#include <cmath>
#include <limits>
#include <numeric>

#include "alidade/core/error.h"
#include "alidade/core/parallel.h"

namespace alidade {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

// Rays of a row of pixels by what they share: those of a column lie at the same x of the plane, so that its
// sine and cosine are computed once for the whole table.
class RowRays {
 public:
  explicit RowRays(const OutputView& view) : view_(view) {
    columns_.reserve(static_cast<std::size_t>(view.size.width));
    for (int x = 0; x < view.size.width; ++x) {
      const double plane = view.planeFromPixel({x, 0}).x();
      const bool is_flat = view.projection == ViewProjection::kRectilinear;
      const auto ray = rayFromPlane(view.projection, {plane, 0});
      columns_.push_back(ray ? Column{is_flat ? plane : ray->x(), ray->z(), true} : Column{0, 0, false});
    }
  }

  // Calls f(column, ray) for the pixels of row y that have a ray.
  template <class F>
  void forEach(int y, F&& f) const {
    const double plane = view_.planeFromPixel({0, y}).y();
    double height = plane;
    double across = 1;
    if (view_.projection == ViewProjection::kEquirectangular) {
      if (!rayFromPlane(view_.projection, {0, plane})) return;
      height = std::sin(plane);
      across = std::cos(plane);
    }
    for (std::size_t x = 0; x < columns_.size(); ++x) {
      const Column& column = columns_[x];
      if (column.has_ray) f(x, Eigen::Vector3d(across * column.x, height, across * column.z));
    }
  }

 private:
  struct Column {
    double x;
    double z;
    bool has_ray;
  };

  const OutputView& view_;
  std::vector<Column> columns_;
};

}  // namespace

RemapTable makeRemapTable(const AnyCamera& camera, ImageSize source_size, const OutputView& view,
                          int num_jobs, const CancelFlag* cancel) {
  expect(view.size.width > 0 && view.size.height > 0, "an output image has pixels");
  const auto width = static_cast<std::size_t>(view.size.width);
  const auto height = static_cast<std::size_t>(view.size.height);
  RemapTable table{.source_size = source_size,
                   .size = view.size,
                   .pixels = std::vector<SourcePixel>(width * height, SourcePixel{kNaN, kNaN})};
  std::vector<std::size_t> num_with_source(height);
  const RowRays rays(view);
  const double right = source_size.width - 0.5;
  const double bottom = source_size.height - 0.5;
  camera.visit([&](const auto& c) {
    parallelFor(
        height, num_jobs,
        [&](std::size_t y) {
          SourcePixel* row = table.pixels.data() + y * width;
          std::size_t count = 0;
          rays.forEach(static_cast<int>(y), [&](std::size_t x, const Eigen::Vector3d& ray) {
            const Projection source = c.project(ray);
            // False for NaN too.
            if (!source.ok() || !(source.pixel.x() >= -0.5 && source.pixel.x() < right)) return;
            if (!(source.pixel.y() >= -0.5 && source.pixel.y() < bottom)) return;
            row[x] = {static_cast<float>(source.pixel.x()), static_cast<float>(source.pixel.y())};
            ++count;
          });
          num_with_source[y] = count;
        },
        cancel);
  });
  table.num_without_source =
      width * height - std::accumulate(num_with_source.begin(), num_with_source.end(), std::size_t{0});
  return table;
}

}  // namespace alidade
