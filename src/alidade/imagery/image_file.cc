// SPDX-License-Identifier: MIT
#include "alidade/imagery/image_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <new>
#include <opencv2/core.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <boost/algorithm/string/predicate.hpp>

#include "alidade/core/error.h"
#include "alidade/core/size_groups.h"
#include "alidade/files/corners_file.h"
#include "alidade/files/text/atomic_file.h"
#include "alidade/imagery/gray_image.h"
#include "alidade/imagery/image_codecs.h"
#include "alidade/imagery/image_container.h"
#include "alidade/imagery/image_damage.h"

namespace alidade {
namespace {

constexpr std::size_t kMaxFileBytes = std::numeric_limits<int>::max();  // OpenCV counts bytes in an int

// Largest size that OpenCV decodes; checked first, because OpenCV's own message names no file.
constexpr int kMaxSide = 1 << 20;
constexpr std::int64_t kMaxPixels = std::int64_t{1} << 30;

Error imageError(const std::string& path, std::string found, std::string next_step) {
  return inputError({.where = path,
                     .found = std::move(found),
                     .expected = "an image (JPEG, PNG, TIFF, BMP, PNM, WebP)",
                     .next_step = std::move(next_step)});
}

Error damagedError(const std::string& path, std::string found) {
  return imageError(
      path, std::move(found),
      "copy or record the image again, convert it to an 8-bit PNG, or remove it from the inputs");
}

/// Describes the first bytes of a file of unknown kind. Text is worth quoting, since it often reveals the
/// cause (a web page instead of a download, a pointer instead of large file storage).
std::string describeStart(std::string_view bytes) {
  if (bytes.starts_with(std::string_view("II+\0", 4)) || bytes.starts_with(std::string_view("MM\0+", 4)))
    return "a BigTIFF image";
  constexpr std::size_t kMaxQuoted = 20;
  const auto is_text = [](char c) { return c >= ' ' && c <= '~'; };
  const auto end =
      std::find_if_not(bytes.begin(), bytes.begin() + std::min(bytes.size(), kMaxQuoted), is_text);
  const std::string start(bytes.begin(), end);
  constexpr std::size_t kLeastText = 4;  // shorter runs occur in binary files by chance
  const bool whole_line = start.size() == bytes.size() || *end == '\n' || *end == '\r';
  if (start.size() >= kLeastText || (!start.empty() && whole_line)) {
    return "the file starts with '" + start + "', not an image";
  }
  return "not an image, or an image in an unknown format";
}

// The container of phones' photographs: a box "ftyp" with the kind of its content.
bool isHeic(std::string_view bytes) {
  constexpr std::array<std::string_view, 5> kKinds = {"heic", "heix", "hevc", "mif1", "msf1"};
  return bytes.size() >= 12 && bytes.substr(4, 4) == "ftyp" &&
         std::ranges::count(kKinds, bytes.substr(8, 4)) > 0;
}

void checkDecodedSize(const std::string& path, const ImageSize& size) {
  const std::int64_t num_pixels = std::int64_t{size.width} * size.height;
  if (size.width <= kMaxSide && size.height <= kMaxSide && num_pixels <= kMaxPixels) return;
  throw inputError({.where = path,
                    .found = "an image of " + sizeText(size) + " pixels",
                    .expected = "at most " + std::to_string(kMaxPixels) + " pixels and " +
                                std::to_string(kMaxSide) + " along a side",
                    .next_step = "check that the file is not damaged"});
}

ContainerInfo checkContainer(const std::string& path, std::string_view content) {
  const ContainerInfo info =
      parseImageContainer({reinterpret_cast<const std::uint8_t*>(content.data()), content.size()});
  // OpenCV would try other decoders, some of which fail badly on damaged files.
  if (info.format == ContainerInfo::Format::kUnknown) {
    if (isHeic(content)) {
      throw imageError(path, "a HEIC photograph, which Alidade cannot read",
                       "convert it with its full size: heif-convert -q 95 '" + path + "' '" +
                           std::filesystem::path(path).replace_extension(".jpg").string() + "'");
    }
    throw imageError(path, describeStart(content),
                     startsLikeCorners(content)
                         ? "give this list of corners a name that ends in .csv, or .vnl if mrcal wrote it"
                         : "open it in an image viewer; copy it again, or remove it from the inputs");
  }
  if (!info.complete) {
    throw damagedError(path, "the image is truncated after " + std::to_string(content.size()) + " bytes");
  }
  if (!info.intact) throw damagedError(path, "the image is damaged: a checksum is wrong");
  if (info.size) checkDecodedSize(path, *info.size);
  if (info.format == ContainerInfo::Format::kJpeg) {
    if (const std::string damage = jpegDamage(content); !damage.empty())
      throw damagedError(path, "the image cannot be decoded without errors (" + damage + ")");
  }
  if (info.format == ContainerInfo::Format::kTiff && isTiffDamaged(content))
    throw damagedError(path, "the image cannot be decoded without errors");
  if (info.format == ContainerInfo::Format::kTiff && info.exif_orientation != 1) {
    // OpenCV (4.6) rotates TIFF images even when told not to.
    throw imageError(path,
                     "a TIFF image that is to be displayed " +
                         describeExifOrientation(info.exif_orientation) + " (orientation tag " +
                         std::to_string(info.exif_orientation) + ")",
                     "save the pixels without an orientation tag, as the sensor delivered them, or as PNG");
  }
  return info;
}

Loaded<cv::Mat> decodeBytes(const std::string& path, std::string content, int flags) {
  const ContainerInfo info = checkContainer(path, content);
  // The decoders' complaints reach the caller as an Error. OpenCV has one log level for the whole process, so
  // it is set once and not restored: another thread may be decoding.
  [[maybe_unused]] static const auto kPreviousLevel =
      cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  const cv::Mat encoded(1, static_cast<int>(content.size()), CV_8UC1, content.data());
  Loaded<cv::Mat> loaded{.image = {}, .exif_orientation = info.exif_orientation};
  try {
    loaded.image = decodeImage(encoded, flags);
  } catch (const cv::Exception& exception) {
    // Not the fault of the image: it may be readable with fewer threads.
    if (exception.code == cv::Error::StsNoMem) throw std::bad_alloc();
    throw damagedError(path, "the image cannot be decoded (" + exception.err + ")");
  }
  if (loaded.image.empty())
    throw damagedError(path, "the image cannot be decoded: it is damaged, or in an unusual format");
  return loaded;
}

/// A copy with the first and third channels swapped: OpenCV's codecs store blue first.
cv::Mat withRedAndBlueSwapped(const cv::Mat& image) {
  if (image.channels() < 3) return image;
  constexpr std::array<int, 8> kSwap = {0, 2, 1, 1, 2, 0, 3, 3};
  cv::Mat swapped(image.size(), image.type());
  cv::mixChannels(&image, 1, &swapped, 1, kSwap.data(), static_cast<std::size_t>(image.channels()));
  return swapped;
}

RasterImage toRasterImage(const std::string& path, const cv::Mat& image) {
  if (image.depth() != CV_8U && image.depth() != CV_16U) {
    throw imageError(path, "samples that are not unsigned integers of 8 or 16 bits",
                     "convert the image to PNG");
  }
  const cv::Mat pixels = withRedAndBlueSwapped(image);
  constexpr int kBitsPerByte = 8;
  RasterImage raster{.size = {pixels.cols, pixels.rows},
                     .num_channels = pixels.channels(),
                     .bits_per_sample = static_cast<int>(pixels.elemSize1()) * kBitsPerByte,
                     .bytes = {}};
  raster.bytes.resize(pixels.total() * pixels.elemSize());
  pixels.copyTo(detail::matOf(raster));
  return raster;
}

}  // namespace

std::string readImageBytes(const std::string& path) {
  // A pipe would block the whole run until something writes to it.
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (std::filesystem::is_other(status)) {
    throw imageError(path, "this is a device or pipe, not a file", "save the image to a file");
  }
  std::string bytes = readBinaryFile(path, kMaxFileBytes);
  if (bytes.empty()) throw damagedError(path, "the file is empty (0 bytes)");
  return bytes;
}

LoadedImage decodeGrayImage(const std::string& path, std::string bytes) {
  const Loaded<cv::Mat> file = decodeBytes(path, std::move(bytes), kGrayFlags);
  if (file.image.channels() != 1 || file.image.depth() > CV_64F)
    throw imageError(path, "samples that cannot be converted to grey", "convert the image to an 8-bit PNG");
  return {.image = detail::grayFromSamples(file.image), .exif_orientation = file.exif_orientation};
}

LoadedImage readGrayImage(const std::string& path) {
  return decodeGrayImage(path, readImageBytes(path));
}

Loaded<RasterImage> readImage(const std::string& path) {
  const Loaded<cv::Mat> file = decodeBytes(path, readImageBytes(path), cv::IMREAD_UNCHANGED);
  return {.image = toRasterImage(path, file.image), .exif_orientation = file.exif_orientation};
}

bool hasJpegName(const std::string& path) {
  return boost::iends_with(path, ".jpg") || boost::iends_with(path, ".jpeg");
}

void writeImage(const std::string& path, const RasterImage& image) {
  expect(image.num_channels != 2, "an image file has 1, 3 or 4 channels");
  const int depth = image.bits_per_sample == 8 ? CV_8U : CV_16U;
  expect(!image.bytes.empty() && image.bytes.size() == image.numPixels() * image.bytesPerPixel(),
         "an image has all its samples");
  const cv::Mat pixels = withRedAndBlueSwapped(detail::matOf(image));
  const bool is_jpeg = hasJpegName(path);
  if (is_jpeg && (depth != CV_8U || image.num_channels == 4)) {
    throw inputError({.where = path,
                      .found = depth != CV_8U ? "16-bit samples" : "an image with an alpha channel",
                      .expected = "8 bits and no alpha channel in a JPEG file",
                      .next_step = "choose a file name that ends with .png"});
  }
  constexpr int kQuality = 95;
  std::vector<std::uint8_t> encoded;
  try {
    // PNG ignores the quality.
    encodeImage(is_jpeg ? ".jpg" : ".png", pixels, encoded, {cv::IMWRITE_JPEG_QUALITY, kQuality});
  } catch (const cv::Exception& exception) {
    throw inputError(
        {.where = path,
         .found = "the image cannot be encoded (" + exception.err + ")",
         .expected = std::string("an image that fits in a ") + (is_jpeg ? "JPEG" : "PNG") + " file",
         .next_step = "use a smaller image"});
  }
  writeFileAtomically(path, {reinterpret_cast<const char*>(encoded.data()), encoded.size()});
}

std::string describeExifOrientation(int orientation) {
  constexpr std::array<std::string_view, 8> kDescriptions = {
      "as stored",
      "mirrored left to right",
      "rotated 180 degrees",
      "mirrored top to bottom",
      "mirrored about the diagonal from top left to bottom right",
      "rotated 90 degrees clockwise",
      "mirrored about the diagonal from top right to bottom left",
      "rotated 90 degrees counter-clockwise",
  };
  if (orientation < 1 || orientation > static_cast<int>(kDescriptions.size()))
    return "with an unknown orientation";
  return std::string(kDescriptions[static_cast<std::size_t>(orientation - 1)]);
}

}  // namespace alidade
