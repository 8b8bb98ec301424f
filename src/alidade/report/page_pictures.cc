// SPDX-License-Identifier: MIT
#include "alidade/report/page_pictures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "alidade/core/parallel.h"

namespace alidade {
namespace {

std::string base64(const std::vector<std::uint8_t>& bytes) {
  static constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) group = (group << 8U) | (i + k < bytes.size() ? bytes[i + k] : 0U);
    for (std::size_t k = 0; k < 4; ++k)
      text += i + k > bytes.size() ? '=' : kDigits[(group >> (6U * (3U - static_cast<unsigned>(k)))) & 63U];
  }
  return text;
}

// How many bytes of JPEG a view may take.
double bytesPerView(std::size_t num_views) {
  constexpr double kMost = 45e3;  // sharp enough for a screen
  constexpr double kFew = 50;
  constexpr double kMany = 1000;
  constexpr double kBytesOfFew = 1.1e6;
  constexpr double kBytesOfMany = 5.2e6;
  const double count = std::max(1.0, static_cast<double>(num_views));
  const double share = std::clamp((count - kFew) / (kMany - kFew), 0.0, 1.0);
  return std::min(kMost, (kBytesOfFew + share * (kBytesOfMany - kBytesOfFew)) / count);
}

}  // namespace

std::string pictureUri(const GrayImage& image, double most_bytes) {
  constexpr double kBytesPerPixel = 0.16;  // at the first quality, of photographs
  const double num_pixels = static_cast<double>(image.size.width) * image.size.height;
  const double scale = std::min(1.0, std::sqrt(most_bytes / kBytesPerPixel / num_pixels));
  const cv::Mat whole(image.size.height, image.size.width, CV_8U,
                      const_cast<std::uint8_t*>(image.pixels.data()));  // OpenCV has no view of constants
  cv::Mat small;
  const cv::Size size(std::max(1, static_cast<int>(std::lround(scale * image.size.width))),
                      std::max(1, static_cast<int>(std::lround(scale * image.size.height))));
  cv::resize(whole, small, size, 0, 0, cv::INTER_AREA);
  std::vector<std::uint8_t> bytes;
  for (const int quality : {72, 55, 40, 25}) {
    cv::imencode(".jpg", small, bytes, {cv::IMWRITE_JPEG_QUALITY, quality});
    if (static_cast<double>(bytes.size()) <= 1.2 * most_bytes) break;
  }
  return "data:image/jpeg;base64," + base64(bytes);
}

std::vector<std::string> viewPictures(const ReportData& data, const ImageOfView& image_of, int num_jobs) {
  std::vector<std::string> pictures(data.views.size());
  if (!image_of) return pictures;
  const double most_bytes = bytesPerView(data.views.size());
  parallelFor(pictures.size(), num_jobs, [&](std::size_t v) {
    const std::optional<GrayImage> image = image_of(data.views[v].image);
    if (image && image->size == data.size) pictures[v] = pictureUri(*image, most_bytes);
  });
  return pictures;
}

}  // namespace alidade
