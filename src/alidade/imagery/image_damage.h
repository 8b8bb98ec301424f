// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

// Damage that OpenCV's decoders do not report.

namespace alidade {

/// What is wrong in the coded data of a JPEG file, in libjpeg's words; empty if nothing is seen. Decoders go
/// on after damage, and what follows it is displaced by whole blocks. The coefficients of a file in one scan
/// are coded again, which must give the same bytes; a changed byte that leaves codes of the same length
/// cannot be seen. A byte or two between the data and the end are the padding of some cameras.
[[nodiscard]] std::string jpegDamage(std::string_view content);

/// Whether the first image of a TIFF file cannot be decoded without an error. OpenCV ignores what libtiff
/// says of single strips and tiles. Damage within valid codes is only seen where they have a checksum
/// (Deflate).
[[nodiscard]] bool isTiffDamaged(std::string_view content);

}  // namespace alidade
