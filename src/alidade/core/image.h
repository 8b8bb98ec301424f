// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace alidade {

/// Width and height in pixels.
struct ImageSize {
  int width = 0;
  int height = 0;
  friend bool operator==(const ImageSize&, const ImageSize&) = default;
};

/// An 8-bit grey image, stored row by row without padding; pixel (x, y) is at y * width + x.
struct GrayImage {
  ImageSize size;
  std::vector<std::uint8_t> pixels;

  [[nodiscard]] bool empty() const { return pixels.empty(); }
  [[nodiscard]] std::uint8_t at(int x, int y) const {
    return pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(size.width) +
                  static_cast<std::size_t>(x)];
  }
};

/// The image with bright and dark exchanged.
[[nodiscard]] inline GrayImage negativeOf(GrayImage image) {
  for (std::uint8_t& pixel : image.pixels) pixel = static_cast<std::uint8_t>(255 - pixel);
  return image;
}

/// The image with left and right exchanged.
[[nodiscard]] inline GrayImage mirroredOf(GrayImage image) {
  for (auto row = image.pixels.begin(); row != image.pixels.end(); row += image.size.width)
    std::reverse(row, row + image.size.width);
  return image;
}

/// An image with its samples as stored in a file. One channel is grey, three are red, green and blue; with
/// two or four channels, the last one is alpha.
struct RasterImage {
  ImageSize size;
  int num_channels = 1;             ///< samples per pixel, 1 to 4
  int bits_per_sample = 8;          ///< 8 or 16
  std::vector<std::uint8_t> bytes;  ///< pixels without padding; 16-bit samples in native byte order

  [[nodiscard]] std::size_t bytesPerPixel() const {
    return static_cast<std::size_t>(num_channels) * static_cast<std::size_t>(bits_per_sample / 8);
  }
  [[nodiscard]] std::size_t numPixels() const {
    return static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
  }
};

}  // namespace alidade
