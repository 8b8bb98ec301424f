// SPDX-License-Identifier: MIT
#include "alidade/imagery/gray_jpeg.h"

#include <cstddef>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "alidade/imagery/image_codecs.h"
#include "support/exif.h"

namespace alidade {
namespace {

cv::Mat blurredNoise(int width, int height, int type) {
  cv::RNG random(static_cast<std::uint64_t>(width * height + type));
  cv::Mat noise(height, width, type);
  random.fill(noise, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(noise, noise, {5, 5}, 1.5);
  cv::normalize(noise, noise, 0, 255, cv::NORM_MINMAX);
  return noise;
}

bool areEqual(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0;
}

cv::Mat row(const std::vector<std::uint8_t>& bytes) {
  return cv::Mat(1, static_cast<int>(bytes.size()), CV_8U, const_cast<std::uint8_t*>(bytes.data()));
}

TEST(GrayJpeg, HasOpenCvsPixelsAndBytes) {
  int num_images = 0;
  for (const cv::Size size : {cv::Size(1, 1), cv::Size(640, 480), cv::Size(333, 217), cv::Size(16, 8)}) {
    for (const int type : {CV_8UC1, CV_8UC3}) {
      for (const int quality : {5, 72, 95}) {
        for (const int is_progressive : {0, 1}) {
          const cv::Mat image = blurredNoise(size.width, size.height, type);
          std::vector<std::uint8_t> bytes;
          cv::imencode(".jpg", image, bytes,
                       {cv::IMWRITE_JPEG_QUALITY, quality, cv::IMWRITE_JPEG_PROGRESSIVE, is_progressive});
          EXPECT_TRUE(areEqual(decodeGrayJpeg(row(bytes)), cv::imdecode(bytes, cv::IMREAD_GRAYSCALE)));
          ++num_images;
          if (type != CV_8UC1 || is_progressive == 1) continue;
          std::vector<std::uint8_t> ours;
          ASSERT_TRUE(encodeGrayJpeg(image, quality, ours));
          EXPECT_EQ(ours, bytes);
        }
      }
    }
  }
  EXPECT_EQ(num_images, 48);
}

// A colour JPEG whose header says that its channels are red, green and blue.
std::vector<std::uint8_t> withRgbHeader(const cv::Mat& image) {
  std::vector<std::uint8_t> jpeg;
  cv::imencode(".jpg", image, jpeg);
  constexpr std::ptrdiff_t kMarkerBytes = 2;
  const auto header = jpeg.begin() + kMarkerBytes;  // APP0 of JFIF, which would say YCbCr
  EXPECT_EQ(header[1], 0xe0);
  jpeg.erase(header, header + kMarkerBytes + 256 * header[2] + header[3]);
  const std::vector<std::uint8_t> adobe = {0xff, 0xee, 0, 14, 'A', 'd', 'o', 'b', 'e', 0, 100, 0, 0, 0, 0, 0};
  jpeg.insert(jpeg.begin() + kMarkerBytes, adobe.begin(), adobe.end());
  return jpeg;
}

TEST(GrayJpeg, LeavesOtherFilesToOpenCv) {
  std::vector<std::uint8_t> png;
  cv::imencode(".png", blurredNoise(64, 48, CV_8UC1), png);
  EXPECT_TRUE(decodeGrayJpeg(row(png)).empty());
  EXPECT_TRUE(decodeGrayJpeg(row({0xff, 0xd8})).empty());
  EXPECT_TRUE(decodeGrayJpeg(row({0xff, 0xd8, 0xff, 0xd9})).empty());
  EXPECT_TRUE(decodeGrayJpeg(cv::Mat()).empty());
  std::vector<std::uint8_t> jpeg;
  cv::imencode(".jpg", blurredNoise(64, 48, CV_8UC1), jpeg);
  for (std::size_t length = 2; length + 2 < jpeg.size(); ++length) {  // truncated anywhere
    const std::vector<std::uint8_t> part(jpeg.begin(), jpeg.begin() + static_cast<std::ptrdiff_t>(length));
    EXPECT_TRUE(decodeGrayJpeg(row(part)).empty()) << length;
  }
  const std::vector<std::uint8_t> rgb = withRgbHeader(blurredNoise(64, 48, CV_8UC3));
  EXPECT_TRUE(decodeGrayJpeg(row(rgb)).empty());
  EXPECT_TRUE(areEqual(decodeImage(row(rgb), kGrayFlags), cv::imdecode(rgb, kGrayFlags)));
}

TEST(GrayJpeg, IsNotTurned) {
  std::vector<std::uint8_t> jpeg;
  cv::imencode(".jpg", blurredNoise(64, 48, CV_8UC3), jpeg);
  for (int orientation = 1; orientation <= 8; ++orientation) {
    const std::vector<std::uint8_t> turned = withExif(jpeg, makeExif(orientation, false));
    EXPECT_TRUE(areEqual(decodeImage(row(turned), kGrayFlags), cv::imdecode(turned, kGrayFlags)));
  }
}

TEST(GrayJpeg, IsNotWrittenBeyondTheFormatsLargestSide) {
  std::vector<std::uint8_t> bytes = {1};
  EXPECT_FALSE(encodeGrayJpeg(cv::Mat(1, 70000, CV_8UC1, cv::Scalar(0)), 90, bytes));
  EXPECT_TRUE(bytes.empty());
}

}  // namespace
}  // namespace alidade
