// SPDX-License-Identifier: MIT
#include "alidade/imagery/remap.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "alidade/camera/batch.h"
#include "alidade/core/error.h"
#include "alidade/core/parallel.h"
#include "alidade/imagery/gray_image.h"

namespace alidade {

RemapTable makeRemapTable(const AnyCamera& camera, ImageSize source_size, const OutputView& view,
                          int num_jobs, const CancelFlag* cancel) {
  const auto rays_of = [&](std::size_t row, const RayColumns& rays) { view.raysOfRow(row, rays); };
  return makeRemapTable(camera, source_size, view.size, rays_of, num_jobs, cancel);
}

RemapTable makeRemapTable(const AnyCamera& camera, ImageSize source_size, ImageSize size,
                          const RaysOfRow& rays_of, int num_jobs, const CancelFlag* cancel) {
  expect(size.width > 0 && size.height > 0, "an output image has pixels");
  const auto width = static_cast<std::size_t>(size.width);
  const auto height = static_cast<std::size_t>(size.height);
  RemapTable table{
      .source_size = source_size, .size = size, .pixels = std::vector<SourcePixel>(width * height)};
  const double right = source_size.width - 0.5;
  const double bottom = source_size.height - 0.5;
  const AnyCamera lens = camera.withPupil({});  // the image shows far points
  std::vector<std::size_t> num_without(height);
  parallelFor(
      height, num_jobs,
      [&](std::size_t row) {
        std::vector<double> numbers(3 * width);
        const std::span all(numbers);
        const RayColumns rays{all.first(width), all.subspan(width, width), all.last(width)};
        rays_of(row, rays);
        // Pixels take the place of the rays.
        std::vector<ProjectStatus> status(width);
        projectBatch(lens, {rays.x, rays.y, rays.z}, {rays.x, rays.y, status});
        std::size_t num_missing = 0;
        SourcePixel* const pixels = table.pixels.data() + row * width;
        for (std::size_t column = 0; column < width; ++column) {
          const double u = rays.x[column];
          const double v = rays.y[column];
          constexpr float kNoSource = std::numeric_limits<float>::quiet_NaN();
          const bool is_inside = u >= -0.5 && v >= -0.5 && u < right && v < bottom;  // false for NaN
          pixels[column] = is_inside ? SourcePixel{static_cast<float>(u), static_cast<float>(v)}
                                     : SourcePixel{kNoSource, kNoSource};
          num_missing += is_inside ? 0 : 1;
        }
        num_without[row] = num_missing;
      },
      cancel);
  table.num_without_source = std::accumulate(num_without.begin(), num_without.end(), std::size_t{0});
  return table;
}

RasterImage remap(const RemapTable& table, const RasterImage& image, Interpolation interpolation,
                  int num_jobs) {
  expect(image.size == table.source_size, "the image has the size that the table is for");
  expect(image.bits_per_sample == 8 || image.bits_per_sample == 16, "samples have 8 or 16 bits");
  expect(image.bytes.size() == image.numPixels() * image.bytesPerPixel(), "the image has all its samples");
  const int width = table.size.width;
  const int height = table.size.height;
  RasterImage out{.size = table.size,
                  .num_channels = image.num_channels,
                  .bits_per_sample = image.bits_per_sample,
                  .bytes = {}};
  out.bytes.resize(out.numPixels() * out.bytesPerPixel());
  const cv::Mat source = detail::matOf(image);
  // OpenCV has no view of constant data; remap() does not write to this.
  const cv::Mat places(height, width, CV_32FC2, const_cast<SourcePixel*>(table.pixels.data()));
  cv::Mat result = detail::matOf(out);
  // Strips that are too small for OpenCV to start threads of its own.
  const int strip_rows = std::max(1, (1 << 16) / width);
  const auto num_strips = static_cast<std::size_t>((height + strip_rows - 1) / strip_rows);
  parallelFor(num_strips, num_jobs, [&](std::size_t i) {
    const int begin = static_cast<int>(i) * strip_rows;
    const int end = std::min(height, begin + strip_rows);
    cv::Mat strip = result.rowRange(begin, end);
    cv::remap(source, strip, places.rowRange(begin, end), cv::noArray(),
              interpolation == Interpolation::kLinear ? cv::INTER_LINEAR : cv::INTER_CUBIC,
              cv::BORDER_REPLICATE);
    for (int y = begin; y < end; ++y) {
      for (int x = 0; x < width; ++x) {
        if (!table.at(x, y).exists()) std::fill_n(result.ptr(y, x), out.bytesPerPixel(), std::uint8_t{0});
      }
    }
  });
  return out;
}

}  // namespace alidade
