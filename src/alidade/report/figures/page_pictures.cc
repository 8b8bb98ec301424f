// SPDX-License-Identifier: MIT
#include "alidade/report/figures/page_pictures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <utility>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "alidade/core/parallel.h"
#include "alidade/imagery/image_codecs.h"

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

// Target size of the JPEG of a view, by the number of given images.
double bytesPerView(std::size_t num_images) {
  constexpr double kMost = 45e3;  // bytes; sharp enough for a screen
  constexpr double kFew = 50;
  constexpr double kMany = 1000;
  constexpr double kBytesOfFew = 1.1e6;
  constexpr double kBytesOfMany = 5.2e6;
  const double count = std::max(1.0, static_cast<double>(num_images));
  const double share = std::clamp((count - kFew) / (kMany - kFew), 0.0, 1.0);
  return std::min(kMost, (kBytesOfFew + share * (kBytesOfMany - kBytesOfFew)) / count);
}

// The image at a half, a quarter and so on of its size, but at least twice the wanted one: averaging whole
// pixels is much faster than averaging fractions.
cv::Mat halved(const cv::Mat& whole, const cv::Size& wanted) {
  int factor = 1;
  while (whole.cols % (2 * factor) == 0 && whole.rows % (2 * factor) == 0 &&
         whole.cols >= 4 * factor * wanted.width && whole.rows >= 4 * factor * wanted.height)
    factor *= 2;
  if (factor == 1) return whole;
  cv::Mat small;
  cv::resize(whole, small, {whole.cols / factor, whole.rows / factor}, 0, 0, cv::INTER_AREA);
  return small;
}

}  // namespace

std::string pictureUri(const GrayImage& image, double most_bytes) {
  constexpr double kBytesPerPixel = 0.16;  // at the first quality, for photographs
  const double num_pixels = static_cast<double>(image.size.width) * image.size.height;
  const double scale = std::min(1.0, std::sqrt(most_bytes / kBytesPerPixel / num_pixels));
  const cv::Mat whole(image.size.height, image.size.width, CV_8U,
                      const_cast<std::uint8_t*>(image.pixels.data()));  // OpenCV has no read-only view
  cv::Mat small;
  const cv::Size size(std::max(1, static_cast<int>(std::lround(scale * image.size.width))),
                      std::max(1, static_cast<int>(std::lround(scale * image.size.height))));
  cv::resize(halved(whole, size), small, size, 0, 0, cv::INTER_AREA);
  std::vector<std::uint8_t> bytes;
  for (const int quality : {72, 55, 40, 25}) {
    encodeImage(".jpg", small, bytes, {cv::IMWRITE_JPEG_QUALITY, quality});
    if (static_cast<double>(bytes.size()) <= 1.2 * most_bytes) break;
  }
  return "data:image/jpeg;base64," + base64(bytes);
}

void PassingPictures::add(const std::string& name, const GrayImage& image, double board_area_px) {
  ViewPicture picture{.uri = pictureUri(image, bytesPerView(num_images_)), .size = image.size};
  const std::lock_guard lock(mutex_);
  pictures_[name] = std::move(picture);
  // For equal areas the first name wins, whatever the order of the threads.
  const bool is_larger =
      board_area_px > largest_area_px_ || (board_area_px == largest_area_px_ && name < largest_name_);
  if (!largest_name_.empty() && !is_larger) return;
  largest_name_ = name;
  largest_area_px_ = board_area_px;
  largest_ = image;
}

std::optional<ViewPicture> PassingPictures::pictureOf(const std::string& name) const {
  const std::lock_guard lock(mutex_);
  const auto found = pictures_.find(name);
  return found == pictures_.end() ? std::nullopt : std::optional(found->second);
}

std::optional<GrayImage> PassingPictures::imageOf(const std::string& name) const {
  const std::lock_guard lock(mutex_);
  return name == largest_name_ ? std::optional(largest_) : std::nullopt;
}

ImageOfView keepingOne(const ImageOfView& image_of, const std::string& name) {
  if (!image_of) return {};
  struct Kept {
    std::mutex mutex;
    std::optional<GrayImage> image;
  };
  return [image_of, name, kept = std::make_shared<Kept>()](const std::string& asked) {
    if (asked != name) return image_of(asked);
    const std::lock_guard lock(kept->mutex);
    if (!kept->image) kept->image = image_of(asked);
    return kept->image;
  };
}

std::vector<std::string> viewPictures(const ReportData& data, int num_images, const PictureSource& source,
                                      int num_jobs) {
  std::vector<std::string> pictures(data.views.size());
  if (!source.image_of) return pictures;
  // One image may show several boards, each of which is a view.
  std::map<std::string, std::size_t> first_of;
  std::vector<std::size_t> firsts;
  for (std::size_t v = 0; v < data.views.size(); ++v)
    if (first_of.emplace(data.views[v].image, v).second) firsts.push_back(v);
  const double most_bytes =
      bytesPerView(std::max(firsts.size(), static_cast<std::size_t>(std::max(0, num_images))));
  parallelFor(firsts.size(), num_jobs, [&](std::size_t i) {
    const std::string& name = data.views[firsts[i]].image;
    const std::optional<ViewPicture> made =
        source.picture_of ? source.picture_of(name) : std::optional<ViewPicture>();
    if (made) {
      if (made->size == data.size) pictures[firsts[i]] = made->uri;
      return;
    }
    const std::optional<GrayImage> image = source.image_of(name);
    if (image && image->size == data.size) pictures[firsts[i]] = pictureUri(*image, most_bytes);
  });
  for (std::size_t v = 0; v < data.views.size(); ++v) pictures[v] = pictures[first_of[data.views[v].image]];
  return pictures;
}

}  // namespace alidade
