// SPDX-License-Identifier: MIT
#include "alidade/imagery/image_container.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cstddef>
#include <limits>
#include <string_view>

#include <webp/decode.h>

#include <boost/crc.hpp>

namespace alidade {
namespace {

using Bytes = std::span<const std::uint8_t>;

bool startsWith(Bytes bytes, std::string_view magic) {
  return bytes.size() >= magic.size() &&
         std::equal(magic.begin(), magic.end(), bytes.begin(),
                    [](char a, std::uint8_t b) { return static_cast<std::uint8_t>(a) == b; });
}

/// The part [at, at + count), or nothing if `bytes` ends before that.
std::optional<Bytes> slice(Bytes bytes, std::size_t at, std::size_t count) {
  if (at > bytes.size() || count > bytes.size() - at) return std::nullopt;
  return bytes.subspan(at, count);
}

std::optional<std::uint32_t> readUint(Bytes bytes, std::size_t at, std::size_t num_bytes,
                                      std::endian order = std::endian::big) {
  const std::optional<Bytes> part = slice(bytes, at, num_bytes);
  if (!part) return std::nullopt;
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < num_bytes; ++i) {
    value = (value << 8) | (*part)[order == std::endian::big ? i : num_bytes - 1 - i];
  }
  return value;
}

std::optional<ImageSize> makeSize(std::optional<std::uint32_t> width, std::optional<std::uint32_t> height) {
  constexpr auto kMax = static_cast<std::uint32_t>(std::numeric_limits<int>::max());
  if (!width || !height || *width - 1 >= kMax || *height - 1 >= kMax) return std::nullopt;
  return ImageSize{static_cast<int>(*width), static_cast<int>(*height)};
}

std::optional<std::endian> tiffByteOrder(Bytes tiff) {
  if (startsWith(tiff, std::string_view("II*\0", 4))) return std::endian::little;
  if (startsWith(tiff, std::string_view("MM\0*", 4))) return std::endian::big;
  return std::nullopt;
}

/// The orientation tag in the first directory of a TIFF file, which is also the form of Exif data.
int tiffOrientation(Bytes tiff) {
  constexpr std::size_t kEntryBytes = 12;
  constexpr std::uint32_t kOrientationTag = 0x0112;
  // Sizes of BYTE, SHORT, LONG, LONG8 and their signed forms, all of which libtiff accepts. Values of 8 bytes
  // are stored elsewhere.
  constexpr std::array<std::size_t, 18> kBytesOfType = {0, 1, 0, 2, 4, 0, 1, 0, 2, 4, 0, 0, 0, 0, 0, 0, 8, 8};
  const std::optional<std::endian> order = tiffByteOrder(tiff);
  if (!order) return 1;
  const auto directory = readUint(tiff, 4, 4, *order);
  const auto num_entries = directory ? readUint(tiff, *directory, 2, *order) : std::nullopt;
  for (std::uint32_t i = 0; i < num_entries.value_or(0); ++i) {
    const std::size_t entry = std::size_t{*directory} + 2 + i * kEntryBytes;
    const auto tag = readUint(tiff, entry, 2, *order);
    if (!tag) break;
    const auto type = readUint(tiff, entry + 2, 2, *order);
    if (tag != kOrientationTag || !type || *type >= kBytesOfType.size() || kBytesOfType[*type] == 0) continue;
    std::size_t at = entry + 8;
    if (kBytesOfType[*type] == 8)
      at = std::size_t{readUint(tiff, at, 4, *order).value_or(0)} + (*order == std::endian::big ? 4 : 0);
    const std::uint32_t value =
        readUint(tiff, at, std::min<std::size_t>(kBytesOfType[*type], 4), *order).value_or(1);
    return value >= 1 && value <= 8 ? static_cast<int>(value) : 1;
  }
  return 1;
}

// Markers of ITU-T T.81, table B.1.
constexpr std::uint8_t kTem = 0x01;
constexpr std::uint8_t kRst0 = 0xD0;
constexpr std::uint8_t kSoi = 0xD8;
constexpr std::uint8_t kEoi = 0xD9;
constexpr std::uint8_t kApp1 = 0xE1;

bool isStandalone(std::uint8_t marker) {
  return marker == kTem || (marker >= kRst0 && marker <= kSoi);
}

bool isStartOfFrame(std::uint8_t marker) {
  constexpr std::uint8_t kDht = 0xC4;
  constexpr std::uint8_t kJpg = 0xC8;
  constexpr std::uint8_t kDac = 0xCC;
  return marker >= 0xC0 && marker <= 0xCF && marker != kDht && marker != kJpg && marker != kDac;
}

/// The next marker at or after `at`, which moves past it. In the coded data, 0xFF is followed by 0, so this
/// skips scan data as well as fill bytes.
std::optional<std::uint8_t> nextMarker(Bytes bytes, std::size_t& at) {
  for (; at + 1 < bytes.size(); ++at) {
    if (bytes[at] != 0xFF || bytes[at + 1] == 0x00 || bytes[at + 1] == 0xFF) continue;
    at += 2;
    return bytes[at - 1];
  }
  return std::nullopt;
}

ContainerInfo parseJpeg(Bytes bytes) {
  constexpr std::string_view kExif("Exif\0\0", 6);
  ContainerInfo info{.format = ContainerInfo::Format::kJpeg, .complete = false};
  bool has_exif = false;
  std::size_t at = 2;
  while (const std::optional<std::uint8_t> marker = nextMarker(bytes, at)) {
    if (marker == kEoi) {
      info.complete = true;
      break;
    }
    if (isStandalone(*marker)) continue;
    const auto length = readUint(bytes, at, 2);  // includes its own two bytes
    const auto segment = length.value_or(0) >= 2 ? slice(bytes, at, *length) : std::nullopt;
    if (!segment) break;
    const Bytes payload = segment->subspan(2);
    if (isStartOfFrame(*marker) && !info.size) {
      info.size = makeSize(readUint(payload, 3, 2), readUint(payload, 1, 2));
    } else if (marker == kApp1 && !has_exif && startsWith(payload, kExif)) {
      has_exif = true;
      info.exif_orientation = tiffOrientation(payload.subspan(kExif.size()));
    }
    at += *length;
  }
  return info;
}

/// CRC as in PNG, annex D.
std::uint32_t checksumOf(Bytes bytes) {
  boost::crc_32_type crc;
  crc.process_bytes(bytes.data(), bytes.size());
  return crc.checksum();
}

ContainerInfo parsePng(Bytes bytes) {
  ContainerInfo info{.format = ContainerInfo::Format::kPng, .complete = false};
  std::size_t at = 8;  // after the signature
  while (const auto length = readUint(bytes, at, 4)) {
    const auto chunk =
        slice(bytes, at + 4, std::size_t{*length} + 4);  // type and data, which the checksum covers
    const auto checksum = chunk ? readUint(bytes, at + 4 + chunk->size(), 4) : std::nullopt;
    if (!checksum) break;
    const Bytes data = chunk->subspan(4);
    const bool is_critical = ((*chunk)[0] & 0x20) == 0;  // upper case: a decoder needs the chunk
    if (is_critical && checksumOf(*chunk) != *checksum) info.intact = false;
    if (startsWith(*chunk, "IHDR")) {
      info.size = makeSize(readUint(data, 0, 4), readUint(data, 4, 4));
    } else if (startsWith(*chunk, "eXIf")) {
      info.exif_orientation = tiffOrientation(data);
    } else if (startsWith(*chunk, "IEND")) {
      info.complete = true;
      break;
    }
    at += 4 + chunk->size() + 4;
  }
  return info;
}

/// OpenCV asks libwebp with this many bytes. Files that libwebp does not recognise go to decoders that search
/// for their signature further on.
ContainerInfo parseWebp(Bytes bytes) {
  constexpr std::size_t kHeaderBytes = 32;
  constexpr std::size_t kRiffBytes = 8;  // the kind and the length of the rest
  const auto kind = slice(bytes, kRiffBytes, 4);
  const auto length = readUint(bytes, 4, 4, std::endian::little);
  if (kind && !startsWith(*kind, "WEBP")) return {};
  if (!kind || *length + kRiffBytes > bytes.size())
    return {.format = ContainerInfo::Format::kOther, .complete = false};
  const auto header = slice(bytes, 0, kHeaderBytes);
  WebPBitstreamFeatures features{};
  if (!header || WebPGetFeatures(header->data(), header->size(), &features) != VP8_STATUS_OK) return {};
  return {.format = ContainerInfo::Format::kOther,
          .size = makeSize(static_cast<std::uint32_t>(features.width),
                           static_cast<std::uint32_t>(features.height))};
}

}  // namespace

ContainerInfo parseImageContainer(std::span<const std::uint8_t> bytes) {
  if (startsWith(bytes, "\xFF\xD8\xFF")) return parseJpeg(bytes);
  if (startsWith(bytes, "\x89PNG\r\n\x1A\n")) return parsePng(bytes);
  if (tiffByteOrder(bytes)) {
    return {.format = ContainerInfo::Format::kTiff, .exif_orientation = tiffOrientation(bytes)};
  }
  if (startsWith(bytes, "RIFF")) return parseWebp(bytes);
  const bool is_pnm = bytes.size() > 2 && bytes[0] == 'P' && bytes[1] >= '1' && bytes[1] <= '6' &&
                      std::isspace(bytes[2]) != 0;
  if (is_pnm || startsWith(bytes, "BM")) return {.format = ContainerInfo::Format::kOther};
  return {};
}

}  // namespace alidade
