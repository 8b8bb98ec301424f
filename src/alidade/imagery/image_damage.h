// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

// Damage that OpenCV's decoders do not report.

namespace alidade {

/// Damage in the coded data of a JPEG file, in libjpeg's words; empty if none is found. Decoders continue
/// after damage, and everything after it is shifted by whole blocks. The coefficients of a file with one scan
/// are encoded again, which must give the same bytes. A changed byte that leaves codes of the same length
/// cannot be detected. One or two bytes between the data and the end are accepted as padding of some cameras.
[[nodiscard]] std::string jpegDamage(std::string_view content);

/// True if the first image of a TIFF file cannot be decoded without an error. OpenCV ignores libtiff's
/// complaints about single strips and tiles. Damage that leaves valid codes is only detected if they have a
/// checksum (Deflate).
[[nodiscard]] bool isTiffDamaged(std::string_view content);

}  // namespace alidade
