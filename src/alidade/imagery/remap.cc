// SPDX-License-Identifier: MIT
#include "alidade/imagery/remap.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "alidade/camera/batch.h"
#include "alidade/core/error.h"
#include "alidade/core/parallel.h"
#include "alidade/imagery/gray_image.h"

namespace alidade {

RemapTable makeRemapTable(const AnyCamera& camera, ImageSize source_size, const OutputView& view,
                          int num_jobs, const CancelFlag* cancel) {
  return makeRemapTable(
      camera, source_size, view.size, [&](const Eigen::Vector2d& pixel) { return view.rayFromPixel(pixel); },
      num_jobs, cancel);
}

RemapTable makeRemapTable(const AnyCamera& camera, ImageSize source_size, ImageSize size,
                          const RayOfPixel& ray_of, int num_jobs, const CancelFlag* cancel) {
  expect(size.width > 0 && size.height > 0, "an output image has pixels");
  const auto width = static_cast<std::size_t>(size.width);
  const auto height = static_cast<std::size_t>(size.height);
  constexpr float kNoSource = std::numeric_limits<float>::quiet_NaN();
  RemapTable table{.source_size = source_size,
                   .size = size,
                   .pixels = std::vector<SourcePixel>(width * height, {kNoSource, kNoSource})};
  const Eigen::Array2d low(-0.5, -0.5);
  const Eigen::Array2d high(source_size.width - 0.5, source_size.height - 0.5);
  parallelFor(
      height, num_jobs,
      [&](std::size_t y) {
        constexpr double kNoRay = std::numeric_limits<double>::quiet_NaN();  // is not projected
        std::vector<Eigen::Vector3d> rays(width);
        for (std::size_t x = 0; x < width; ++x)
          rays[x] = ray_of({x, y}).value_or(Eigen::Vector3d::Constant(kNoRay));
        std::vector<Projection> sources(width);
        projectBatch(camera, rays, sources);
        for (std::size_t x = 0; x < width; ++x) {
          const Eigen::Array2d place = sources[x].pixel.array();
          if (!sources[x].ok() || !(place >= low && place < high).all()) continue;
          table.pixels[y * width + x] = {static_cast<float>(place.x()), static_cast<float>(place.y())};
        }
      },
      cancel);
  table.num_without_source = static_cast<std::size_t>(std::count_if(
      table.pixels.begin(), table.pixels.end(), [](const SourcePixel& pixel) { return !pixel.exists(); }));
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
