// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "alidade/core/image.h"

namespace alidade {

struct LoadedImage {
  GrayImage image;           ///< the pixels as the sensor stored them, whatever the orientation tag says
  int exif_orientation = 1;  ///< Exif's 1 to 8; viewers and some programs apply it, readGrayImage does not
  int bits_per_sample = 8;   ///< of the decoded samples: 8, 16, 32 or 64
};

/// Reads an image of any kind that OpenCV decodes: grey or colour, with or without alpha. Samples of more
/// than 8 bits are scaled linearly so that their 0.1 % quantile becomes 0 and their 99.9 % quantile 255, and
/// clamped: 10 and 12-bit data in 16-bit files would be almost black otherwise, and so would be any image
/// with one hot pixel if that were the greatest. Where all are the same they become 0, and so do samples that
/// are not a number. Fit for finding features, not for measuring light.
/// @throws Error (kInput) when the file is missing, unreadable, empty, truncated, damaged, too large or no
/// image, and for a TIFF file that asks to be turned.
[[nodiscard]] LoadedImage readGrayImage(const std::string& path);

struct LoadedRaster {
  RasterImage image;
  int exif_orientation = 1;  ///< as in LoadedImage; not applied
};

/// Reads an image with its colours, alpha and depth, every sample as stored: of 8 or 16 bits, grey, or in the
/// order red, green, blue, alpha. Palettes are resolved, and grey with alpha becomes colour with alpha.
/// @throws Error (kInput) as readGrayImage, and for samples of more than 16 bits, signed ones, and fractions.
[[nodiscard]] LoadedRaster readImage(const std::string& path);

/// True for a name with the extension of a JPEG file, in capitals or not.
[[nodiscard]] bool hasJpegName(const std::string& path);

/// Writes a JPEG file of quality 95 if the name is one of a JPEG file, and a PNG file, without loss,
/// otherwise; by writeFileAtomically. Neither says anything of orientation.
/// @throws Error (kInput) when the file cannot be written, and for a JPEG file of 16 bits or with alpha;
/// std::logic_error for an empty image.
void writeImage(const std::string& path, const RasterImage& image);

/// Writes a PNG file, whatever the name ends with, by writeFileAtomically.
/// @throws Error (kInput) when the file cannot be written; std::logic_error for an empty image.
void writeGrayPng(const std::string& path, const GrayImage& image);

/// The same for an image in colour.
void writeColorPng(const std::string& path, const ColorImage& image);

/// What a viewer does to the stored pixels to show them upright, in words: "rotated 90 degrees clockwise"
/// for 6.
[[nodiscard]] std::string describeExifOrientation(int orientation);

}  // namespace alidade
