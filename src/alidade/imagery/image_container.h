// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "alidade/core/image.h"

namespace alidade {

/// Findings from the structure of an image file, without decoding a pixel. Decoders silently fill the missing
/// part of a truncated JPEG with grey, so this must be checked first.
struct ContainerInfo {
  enum class Format {
    kUnknown,  ///< the first bytes match no kind below
    kJpeg,
    kPng,
    kTiff,   ///< not BigTIFF
    kOther,  ///< BMP, WebP, PBM, PGM or PPM
  };
  Format format = Format::kUnknown;
  /// The end of the image is present (JPEG, PNG, WebP; true for others). Bytes after it do not matter.
  bool complete = true;
  /// The checksums of the chunks that a decoder needs are right (PNG; true for others).
  bool intact = true;
  /// The Exif or TIFF orientation, 1 to 8; 1 (as stored) if the file states none or an invalid one.
  int exif_orientation = 1;
  std::optional<ImageSize> size =
      std::nullopt;  ///< of the stored pixels (JPEG, PNG, WebP), both sides positive
};

/// Reads any bytes safely: unreadable properties keep their defaults, and the image counts as incomplete.
[[nodiscard]] ContainerInfo parseImageContainer(std::span<const std::uint8_t> bytes);

}  // namespace alidade
