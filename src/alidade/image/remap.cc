// SPDX-License-Identifier: MIT
#include "alidade/image/remap.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "alidade/core/error.h"
#include "alidade/core/parallel.h"

namespace alidade {
namespace {

// The samples around a place along one axis, with their weights. Beyond the border the border's own count.
template <int kCount>
struct Taps {
  std::array<int, kCount> at;
  std::array<float, kCount> weight;
};

struct LinearKernel {
  static constexpr int kCount = 2;

  static Taps<kCount> taps(float place, int length) {
    const float inside = std::clamp(place, 0.0F, static_cast<float>(length - 1));
    const int first = static_cast<int>(inside);
    const float t = inside - static_cast<float>(first);
    return {{first, std::min(first + 1, length - 1)}, {1 - t, t}};
  }
};

// R. Keys, Cubic convolution interpolation for digital image processing, IEEE Transactions on Acoustics,
// Speech, and Signal Processing 29 (1981).
struct CubicKernel {
  static constexpr int kCount = 4;

  static Taps<kCount> taps(float place, int length) {
    const float inside = std::clamp(place, 0.0F, static_cast<float>(length - 1));
    const int first = static_cast<int>(inside);
    const float t = inside - static_cast<float>(first);
    const float t2 = t * t;
    const float t3 = t2 * t;
    Taps<kCount> result;
    for (int i = 0; i < kCount; ++i)
      result.at[static_cast<std::size_t>(i)] = std::clamp(first + i - 1, 0, length - 1);
    result.weight = {-0.5F * t + t2 - 0.5F * t3, 1 - 2.5F * t2 + 1.5F * t3, 0.5F * t + 2 * t2 - 1.5F * t3,
                     -0.5F * t2 + 0.5F * t3};
    return result;
  }
};

template <class Sample>
Sample rounded(float value) {
  constexpr auto kMax = static_cast<float>(std::numeric_limits<Sample>::max());
  return static_cast<Sample>(std::clamp(value + 0.5F, 0.0F, kMax));
}

template <class Kernel, class Sample, int kChannels>
void remapRow(const SourcePixel* places, int width, const Sample* source, ImageSize source_size,
              Sample* out) {
  const auto stride = static_cast<std::ptrdiff_t>(source_size.width) * kChannels;
  for (int x = 0; x < width; ++x, out += kChannels) {
    const SourcePixel& place = places[x];
    if (!place.exists()) continue;  // the output starts as zeros
    const auto columns = Kernel::taps(place.x, source_size.width);
    const auto rows = Kernel::taps(place.y, source_size.height);
    std::array<float, kChannels> sum{};
    for (std::size_t j = 0; j < Kernel::kCount; ++j) {
      const Sample* row = source + rows.at[j] * stride;
      std::array<float, kChannels> line{};
      for (std::size_t i = 0; i < Kernel::kCount; ++i) {
        const Sample* pixel = row + static_cast<std::ptrdiff_t>(columns.at[i]) * kChannels;
        for (std::size_t c = 0; c < kChannels; ++c)
          line[c] += columns.weight[i] * static_cast<float>(pixel[c]);
      }
      for (std::size_t c = 0; c < kChannels; ++c) sum[c] += rows.weight[j] * line[c];
    }
    for (std::size_t c = 0; c < kChannels; ++c) out[c] = rounded<Sample>(sum[c]);
  }
}

template <class Kernel, class Sample, int kChannels>
void remapRows(const RemapTable& table, const std::uint8_t* source, std::uint8_t* out, int num_jobs) {
  const auto width = static_cast<std::size_t>(table.size.width);
  // Memory from std::vector is aligned for any type of sample.
  const auto* samples = reinterpret_cast<const Sample*>(source);
  auto* out_samples = reinterpret_cast<Sample*>(out);
  parallelFor(static_cast<std::size_t>(table.size.height), num_jobs, [&](std::size_t y) {
    remapRow<Kernel, Sample, kChannels>(table.pixels.data() + y * width, table.size.width, samples,
                                        table.source_size, out_samples + y * width * kChannels);
  });
}

template <class Kernel, class Sample>
void remapChannels(const RemapTable& table, int num_channels, const std::uint8_t* source, std::uint8_t* out,
                   int num_jobs) {
  switch (num_channels) {
    case 1:
      return remapRows<Kernel, Sample, 1>(table, source, out, num_jobs);
    case 2:
      return remapRows<Kernel, Sample, 2>(table, source, out, num_jobs);
    case 3:
      return remapRows<Kernel, Sample, 3>(table, source, out, num_jobs);
    case 4:
      return remapRows<Kernel, Sample, 4>(table, source, out, num_jobs);
    default:
      expect(false, "an image has 1 to 4 channels");
  }
}

template <class Sample>
void remapSamples(const RemapTable& table, Interpolation interpolation, int num_channels,
                  const std::uint8_t* source, std::uint8_t* out, int num_jobs) {
  if (interpolation == Interpolation::kLinear)
    return remapChannels<LinearKernel, Sample>(table, num_channels, source, out, num_jobs);
  remapChannels<CubicKernel, Sample>(table, num_channels, source, out, num_jobs);
}

}  // namespace

RasterImage remap(const RemapTable& table, const RasterImage& image, Interpolation interpolation,
                  int num_jobs) {
  expect(image.size == table.source_size, "the image has the size that the table is for");
  expect(image.bits_per_sample == 8 || image.bits_per_sample == 16, "samples have 8 or 16 bits");
  expect(image.bytes.size() == image.numPixels() * image.bytesPerPixel(), "the image has all its samples");
  RasterImage out{.size = table.size,
                  .num_channels = image.num_channels,
                  .bits_per_sample = image.bits_per_sample,
                  .bytes = {}};
  out.bytes.resize(out.numPixels() * out.bytesPerPixel());
  const auto work = image.bits_per_sample == 8 ? remapSamples<std::uint8_t> : remapSamples<std::uint16_t>;
  work(table, interpolation, image.num_channels, image.bytes.data(), out.bytes.data(), num_jobs);
  return out;
}

GrayImage remap(const RemapTable& table, const GrayImage& image, Interpolation interpolation, int num_jobs) {
  expect(image.size == table.source_size, "the image has the size that the table is for");
  GrayImage out{.size = table.size, .pixels = std::vector<std::uint8_t>(table.pixels.size())};
  remapSamples<std::uint8_t>(table, interpolation, 1, image.pixels.data(), out.pixels.data(), num_jobs);
  return out;
}

}  // namespace alidade
