// SPDX-License-Identifier: MIT
#include "support/degrade.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "alidade/core/random.h"

namespace alidade {
namespace {

cv::Mat floatsOf(const GrayImage& image) {
  const cv::Mat bytes(image.size.height, image.size.width, CV_8U,
                      const_cast<std::uint8_t*>(image.pixels.data()));
  cv::Mat floats;
  bytes.convertTo(floats, CV_32F);
  return floats;
}

// A kernel of the share of each pixel that a shape covers, from 16 x 16 samples.
template <class Inside>
cv::Mat coverageKernel(int half, const Inside& inside) {
  constexpr int kSamples = 16;
  cv::Mat kernel(2 * half + 1, 2 * half + 1, CV_32F, cv::Scalar(0));
  for (int y = -half; y <= half; ++y) {
    for (int x = -half; x <= half; ++x) {
      int count = 0;
      for (int i = 0; i < kSamples * kSamples; ++i) {
        const double sx = x + (i % kSamples + 0.5) / kSamples - 0.5;
        const double sy = y + (i / kSamples + 0.5) / kSamples - 0.5;
        if (inside(sx, sy)) ++count;
      }
      kernel.at<float>(y + half, x + half) = static_cast<float>(count);
    }
  }
  return kernel / cv::sum(kernel)[0];
}

cv::Mat motionKernel() {
  constexpr double kLength = 8;
  constexpr double kHalfWidth = 0.5;
  const double angle = -30 * std::numbers::pi / 180;  // y points down
  return coverageKernel(5, [angle](double x, double y) {
    return std::abs(x * std::cos(angle) + y * std::sin(angle)) <= kLength / 2 &&
           std::abs(y * std::cos(angle) - x * std::sin(angle)) <= kHalfWidth;
  });
}

cv::Mat defocusKernel() {
  constexpr double kRadius = 4;
  return coverageKernel(5, [](double x, double y) { return std::hypot(x, y) <= kRadius; });
}

cv::Mat filtered(const cv::Mat& image, const cv::Mat& kernel) {
  cv::Mat result;
  cv::filter2D(image, result, CV_32F, kernel, {-1, -1}, 0, cv::BORDER_REPLICATE);
  return result;
}

void addNoise(cv::Mat& image, double noise, std::uint64_t seed) {
  Random random(seed);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) image.at<float>(y, x) += static_cast<float>(noise * random.normal());
  }
}

cv::Mat gammaEncoded(const cv::Mat& light) {
  cv::Mat share = cv::max(light, 0.0) / 255.0;
  cv::pow(share, 1 / 2.2, share);
  return share * 255.0;
}

cv::Mat sharpened(const cv::Mat& image) {
  cv::Mat soft;
  cv::GaussianBlur(image, soft, {0, 0}, 1.5);
  return image + 1.5 * (image - soft);
}

}  // namespace

std::string_view nameOf(Degradation degradation) {
  switch (degradation) {
    case Degradation::kNone:
      return "none";
    case Degradation::kMotionBlur:
      return "motion 8 px";
    case Degradation::kDefocus:
      return "defocus";
    case Degradation::kGamma:
      return "gamma";
    case Degradation::kClippedWhite:
      return "clipped white";
    case Degradation::kSharpened:
      return "sharpened";
    case Degradation::kJpeg:
      return "JPEG q30";
  }
  return "unknown";
}

GrayImage degraded(const GrayImage& image, Degradation degradation, double noise, std::uint64_t seed) {
  cv::Mat work = floatsOf(image);
  if (degradation == Degradation::kMotionBlur) work = filtered(work, motionKernel());
  if (degradation == Degradation::kDefocus) work = filtered(work, defocusKernel());
  if (degradation == Degradation::kClippedWhite) work *= 1.5;
  if (noise > 0) addNoise(work, noise, seed);
  if (degradation == Degradation::kGamma) work = gammaEncoded(work);
  if (degradation == Degradation::kSharpened) work = sharpened(work);
  cv::Mat bytes;
  work.convertTo(bytes, CV_8U);  // rounds, and cuts at 0 and 255
  if (degradation == Degradation::kJpeg) {
    std::vector<std::uint8_t> file;
    cv::imencode(".jpg", bytes, file, {cv::IMWRITE_JPEG_QUALITY, 30});
    bytes = cv::imdecode(file, cv::IMREAD_GRAYSCALE);
  }
  GrayImage result{.size = image.size, .pixels = {}};
  result.pixels.assign(bytes.datastart, bytes.dataend);
  return result;
}

}  // namespace alidade
