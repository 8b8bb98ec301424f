// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "alidade/core/image.h"

namespace alidade {

struct LoadedImage {
  GrayImage image;           ///< the pixels as stored; the orientation tag is ignored
  int exif_orientation = 1;  ///< Exif's 1 to 8; readGrayImage() does not apply it
};

/// Reads a JPEG, PNG, TIFF, BMP, PNM (PBM, PGM, PPM) or WebP file, recognised by its first bytes: grey or
/// colour, with or without alpha. Samples of more than 8 bits are scaled linearly and clamped, so that their
/// 0.1 % quantile becomes 0 and their 99.9 % quantile 255. Otherwise 10-bit and 12-bit data in 16-bit files
/// would be almost black. If all samples are equal, they become 0; NaN also becomes 0. Use the result to find
/// features, not for photometry.
/// @throws Error (kInput) if the file is missing, unreadable, empty, truncated, damaged, too large or not an
/// image, or if it is a TIFF file with an orientation tag.
[[nodiscard]] LoadedImage readGrayImage(const std::string& path);

/// The bytes of an image file, not yet decoded.
/// @throws Error (kInput) if the file is missing, unreadable, empty or too large, or is a device or a pipe
[[nodiscard]] std::string readImageBytes(const std::string& path);
/// readGrayImage() for bytes that were read before; messages use `path` as the file name.
[[nodiscard]] LoadedImage decodeGrayImage(const std::string& path, std::string bytes);

/// Throws if an image in any container is too large to be decoded.
/// @throws Error (kInput)
void checkDecodedSize(const std::string& path, const ImageSize& size);

struct LoadedRaster {
  RasterImage image;
  int exif_orientation = 1;  ///< same as in LoadedImage; not applied
};

/// Reads an image with its colours, alpha and depth, with every sample as stored: 8 or 16 bits, grey or in
/// the order red, green, blue, alpha. Palettes are resolved, and grey with alpha becomes colour with alpha.
/// @throws Error (kInput) like readGrayImage(), and for samples of more than 16 bits, signed ones, and
/// fractions.
[[nodiscard]] LoadedRaster readImage(const std::string& path);

/// True for a name with the extension of a JPEG file, in upper or lower case.
[[nodiscard]] bool hasJpegName(const std::string& path);

/// Writes a JPEG file of quality 95 if the name has a JPEG extension, otherwise a lossless PNG file, by
/// writeFileAtomically(). Neither gets an orientation tag.
/// @throws Error (kInput) if the file cannot be written, and for a JPEG file with 16 bits or alpha;
/// std::logic_error for an empty image.
void writeImage(const std::string& path, const RasterImage& image);

/// The transformation by which viewers show the stored pixels upright, in words: "rotated 90 degrees
/// clockwise" for 6.
[[nodiscard]] std::string describeExifOrientation(int orientation);

}  // namespace alidade
