// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/core/image.h"
#include "alidade/imagery/remap_table.h"

namespace alidade {

enum class Interpolation {
  kLinear,  ///< between the four pixels around
  kCubic,   ///< through the 16 around, by Keys' kernel (a = -1/2): sharper, may overshoot at edges
};

/// The output image of a table: for each pixel the source's samples at its place, in the same number of
/// channels and bits. Pixels without a source are 0 in all channels. The outer half of the source's border
/// pixels takes the border's own value, so that nothing dark mixes in there. Places are used as they are,
/// without rounding to fractions of a pixel.
///
/// Where the output has less resolution than the source nothing is averaged: fine patterns may alias.
/// @param image  of the table's source size, with samples of 8 or 16 bits
/// @param num_jobs  threads; 0: one a processor. The image does not depend on it.
/// @throws std::logic_error for another image
[[nodiscard]] RasterImage remap(const RemapTable& table, const RasterImage& image,
                                Interpolation interpolation, int num_jobs = 1);

/// The same for an 8-bit grey image.
[[nodiscard]] GrayImage remap(const RemapTable& table, const GrayImage& image, Interpolation interpolation,
                              int num_jobs = 1);

}  // namespace alidade
