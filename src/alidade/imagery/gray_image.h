// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

#include "alidade/core/image.h"

namespace cv {
class Mat;
}  // namespace cv

namespace alidade {

/// Samples of an image in memory that belongs to the caller.
struct RasterView {
  const void* samples = nullptr;  ///< row by row; 16-bit samples in native byte order and aligned
  ImageSize size;
  int num_channels = 1;        ///< 1 (grey), 3, or 4 (the last one is alpha, which is ignored)
  int bits_per_sample = 8;     ///< 8 or 16
  std::size_t row_bytes = 0;   ///< from one row to the next
  bool is_blue_first = false;  ///< the channels are blue, green and red, as in OpenCV
};

/// The grey image in which boards are searched. 16-bit samples are scaled as in readGrayImage().
[[nodiscard]] GrayImage grayImage(const RasterView& image);

namespace detail {
/// Images as OpenCV matrices, which must not be written to: OpenCV has no views of constant data.
[[nodiscard]] cv::Mat matOf(const GrayImage& image);
[[nodiscard]] cv::Mat matOf(const RasterImage& image);
/// A smaller image with one `fraction`-th of the width and height, rounded down: each pixel is the mean of
/// fraction^2. Its pixel c lies at fraction (c + 0.5) - 0.5 of the whole. Empty if it would have no pixels.
[[nodiscard]] GrayImage shrunk(const GrayImage& image, int fraction);
/// A grey image of a matrix of one channel. Samples that are not bytes are scaled so that their 0.1 %
/// quantile becomes 0 and their 99.9 % quantile 255; NaN becomes 0.
[[nodiscard]] GrayImage grayFromSamples(const cv::Mat& image);
}  // namespace detail

}  // namespace alidade
