// SPDX-License-Identifier: MIT
#include "alidade/imagery/remap.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "alidade/core/error.h"
#include "alidade/core/parallel.h"
#include "alidade/core/vector_code.h"

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
    return {{first, std::min(first + 1, length - 1)}, weights(inside - static_cast<float>(first))};
  }

  static std::array<float, kCount> weights(float t) { return {1 - t, t}; }
};

// R. Keys, Cubic convolution interpolation for digital image processing, IEEE Transactions on Acoustics,
// Speech, and Signal Processing 29 (1981).
struct CubicKernel {
  static constexpr int kCount = 4;

  static Taps<kCount> taps(float place, int length) {
    const float inside = std::clamp(place, 0.0F, static_cast<float>(length - 1));
    const int first = static_cast<int>(inside);
    Taps<kCount> result;
    for (int i = 0; i < kCount; ++i)
      result.at[static_cast<std::size_t>(i)] = std::clamp(first + i - 1, 0, length - 1);
    result.weight = weights(inside - static_cast<float>(first));
    return result;
  }

  static std::array<float, kCount> weights(float t) {
    const float t2 = t * t;
    const float t3 = t2 * t;
    return {-0.5F * t + t2 - 0.5F * t3, 1 - 2.5F * t2 + 1.5F * t3, 0.5F * t + 2 * t2 - 1.5F * t3,
            -0.5F * t2 + 0.5F * t3};
  }
};

template <class Sample>
Sample rounded(float value) {
  constexpr auto kMax = static_cast<float>(std::numeric_limits<Sample>::max());
  return static_cast<Sample>(std::clamp(value + 0.5F, 0.0F, kMax));
}

// The samples of one pixel side by side. Three are read as four, so that one more pixel must follow.
#if defined(ALIDADE_HAS_VECTORS)
template <class Sample>
struct Four;
template <>
struct Four<std::uint8_t> {
  using type = std::uint8_t __attribute__((vector_size(4)));
};
template <>
struct Four<std::uint16_t> {
  using type = std::uint16_t __attribute__((vector_size(8)));
};
using FourFloats = float __attribute__((vector_size(16)));

template <int kChannels>
constexpr bool kIsSideBySide = kChannels >= 3;

template <class Sample>
FourFloats loadFour(const Sample* from) {
  typename Four<Sample>::type samples;
  std::memcpy(&samples, from, sizeof samples);
  return __builtin_convertvector(samples, FourFloats);
}
#else
template <int kChannels>
constexpr bool kIsSideBySide = false;
#endif

// The samples around a place all of whose taps lie inside of the image, one after another from `first`.
template <class Kernel, class Sample, int kChannels>
void interpolateInside(const std::array<float, Kernel::kCount>& across,
                       const std::array<float, Kernel::kCount>& down, const Sample* first,
                       std::ptrdiff_t stride, Sample* out) {
  if constexpr (kIsSideBySide<kChannels>) {
    FourFloats sum = {};
    for (std::size_t j = 0; j < Kernel::kCount; ++j, first += stride) {
      FourFloats line = across[0] * loadFour(first);
      for (std::size_t i = 1; i < Kernel::kCount; ++i) line += across[i] * loadFour(first + i * kChannels);
      sum += down[j] * line;
    }
    for (int c = 0; c < kChannels; ++c) out[c] = rounded<Sample>(sum[c]);
  } else {
    for (int c = 0; c < kChannels; ++c) {
      const Sample* row = first + c;
      float sum = 0;
      for (std::size_t j = 0; j < Kernel::kCount; ++j, row += stride) {
        float line = 0;
        for (std::size_t i = 0; i < Kernel::kCount; ++i)
          line += across[i] * static_cast<float>(row[i * kChannels]);
        sum += down[j] * line;
      }
      out[c] = rounded<Sample>(sum);
    }
  }
}

// The same where the border takes part.
template <class Kernel, class Sample, int kChannels>
void interpolateAtBorder(const SourcePixel& place, const Sample* source, ImageSize source_size, Sample* out) {
  const auto stride = static_cast<std::ptrdiff_t>(source_size.width) * kChannels;
  const auto columns = Kernel::taps(place.x, source_size.width);
  const auto rows = Kernel::taps(place.y, source_size.height);
  for (int c = 0; c < kChannels; ++c) {
    float sum = 0;
    for (std::size_t j = 0; j < Kernel::kCount; ++j) {
      const Sample* row = source + rows.at[j] * stride + c;
      float line = 0;
      for (std::size_t i = 0; i < Kernel::kCount; ++i)
        line += columns.weight[i] *
                static_cast<float>(row[static_cast<std::ptrdiff_t>(columns.at[i]) * kChannels]);
      sum += rows.weight[j] * line;
    }
    out[c] = rounded<Sample>(sum);
  }
}

template <class Kernel, class Sample, int kChannels>
void remapRow(const SourcePixel* places, int width, const Sample* source, ImageSize source_size,
              Sample* out) {
  constexpr int kBefore = Kernel::kCount / 2 - 1;
  constexpr int kAfter = Kernel::kCount / 2 + (kIsSideBySide<kChannels> && kChannels == 3 ? 1 : 0);
  const auto stride = static_cast<std::ptrdiff_t>(source_size.width) * kChannels;
  const auto right = static_cast<float>(source_size.width - kAfter);
  const auto bottom = static_cast<float>(source_size.height - kAfter);
  for (int x = 0; x < width; ++x, out += kChannels) {
    const SourcePixel& place = places[x];
    // False where there is no source.
    if (place.x >= kBefore && place.x < right && place.y >= kBefore && place.y < bottom) {
      const int column = static_cast<int>(place.x);
      const int row = static_cast<int>(place.y);
      const Sample* first = source + (row - kBefore) * stride + (column - kBefore) * kChannels;
      interpolateInside<Kernel, Sample, kChannels>(Kernel::weights(place.x - static_cast<float>(column)),
                                                   Kernel::weights(place.y - static_cast<float>(row)), first,
                                                   stride, out);
    } else if (place.exists()) {
      interpolateAtBorder<Kernel, Sample, kChannels>(place, source, source_size, out);
    }  // else zero, as the output starts
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
