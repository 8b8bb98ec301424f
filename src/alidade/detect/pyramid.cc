// SPDX-License-Identifier: MIT
#include "alidade/detect/pyramid.h"

namespace alidade {

GrayImage halved(const GrayImage& image) {
  const auto width = static_cast<std::size_t>(image.size.width / 2);
  const auto height = static_cast<std::size_t>(image.size.height / 2);
  GrayImage half{.size = {.width = image.size.width / 2, .height = image.size.height / 2}, .pixels = {}};
  if (width == 0 || height == 0) return {};
  half.pixels.resize(width * height);
  const auto stride = static_cast<std::size_t>(image.size.width);
  for (std::size_t y = 0; y < height; ++y) {
    const std::uint8_t* upper = image.pixels.data() + 2 * y * stride;
    const std::uint8_t* lower = upper + stride;
    std::uint8_t* out = half.pixels.data() + y * width;
    for (std::size_t x = 0; x < width; ++x) {
      const unsigned sum = unsigned{upper[2 * x]} + upper[2 * x + 1] + lower[2 * x] + lower[2 * x + 1];
      out[x] = static_cast<std::uint8_t>((sum + 2) / 4);
    }
  }
  return half;
}

}  // namespace alidade
