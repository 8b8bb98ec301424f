// SPDX-License-Identifier: MIT
#include "alidade/imagery/gray_image.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "alidade/core/error.h"

namespace alidade {
namespace {

// Smallest and largest finite sample without the lowest and highest 0.1 %, so that hot or dead pixels do not
// matter. Images of up to 1000 pixels lose no sample.
std::pair<double, double> robustRange(const cv::Mat& image) {
  constexpr std::size_t kMaxSamples = 1'000'000;  // of larger images, every k-th pixel is used
  constexpr double kTail = 0.001;
  const std::size_t step = (image.total() + kMaxSamples - 1) / kMaxSamples;
  const auto num_columns = static_cast<std::size_t>(image.cols);
  std::vector<double> samples;
  samples.reserve(std::min(image.total(), kMaxSamples));
  std::vector<double> row;
  std::size_t i = 0;
  for (int y = 0; y < image.rows; ++y) {
    const std::size_t begin = static_cast<std::size_t>(y) * num_columns;
    image.row(y).convertTo(row, CV_64F);
    for (; i < begin + num_columns; i += step) {
      if (std::isfinite(row[i - begin])) samples.push_back(row[i - begin]);
    }
  }
  if (samples.empty()) return {};
  const std::size_t last = samples.size() - 1;
  const auto tail = static_cast<std::size_t>(kTail * static_cast<double>(last));
  const auto low = samples.begin() + static_cast<std::ptrdiff_t>(tail);
  const auto high = samples.begin() + static_cast<std::ptrdiff_t>(last - tail);
  std::nth_element(samples.begin(), low, samples.end());
  const double low_value = *low;
  std::nth_element(low, high, samples.end());
  return {low_value, *high};
}

}  // namespace

namespace detail {

GrayImage grayFromSamples(const cv::Mat& image) {
  GrayImage gray{.size = {image.cols, image.rows}, .pixels = std::vector<std::uint8_t>(image.total())};
  if (image.depth() == CV_8U) {
    image.copyTo(cv::Mat(image.size(), CV_8UC1, gray.pixels.data()));
    return gray;
  }
  const auto [low, high] = robustRange(image);
  // Halves, because the difference of distant values (doubles) may overflow.
  const double half_range = high / 2 - low / 2;
  std::uint8_t* out = gray.pixels.data();
  std::vector<double> row;
  for (int y = 0; y < image.rows; ++y) {
    image.row(y).convertTo(row, CV_64F);
    for (const double sample : row) {
      const double share = (sample / 2 - low / 2) / half_range;
      // Samples outside the range are clamped; both comparisons are false for NaN.
      *out++ = share >= 1.0 ? 255 : share > 0.0 ? static_cast<std::uint8_t>(std::lround(share * 255.0)) : 0;
    }
  }
  return gray;
}

}  // namespace detail

GrayImage grayImage(const RasterView& image) {
  expect(image.bits_per_sample == 8 || image.bits_per_sample == 16, "samples of 8 or 16 bits");
  expect(image.num_channels == 1 || image.num_channels == 3 || image.num_channels == 4, "1, 3 or 4 channels");
  const int depth = image.bits_per_sample == 8 ? CV_8U : CV_16U;
  // OpenCV has no matrix of constant memory; nothing here writes to it.
  const cv::Mat given(image.size.height, image.size.width, CV_MAKETYPE(depth, image.num_channels),
                      const_cast<void*>(image.samples), image.row_bytes);
  if (image.num_channels == 1) return detail::grayFromSamples(given);
  const bool has_alpha = image.num_channels == 4;
  cv::Mat gray;
  if (image.is_blue_first) {
    cv::cvtColor(given, gray, has_alpha ? cv::COLOR_BGRA2GRAY : cv::COLOR_BGR2GRAY);
  } else {
    cv::cvtColor(given, gray, has_alpha ? cv::COLOR_RGBA2GRAY : cv::COLOR_RGB2GRAY);
  }
  return detail::grayFromSamples(gray);
}

}  // namespace alidade
