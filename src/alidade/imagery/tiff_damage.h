// SPDX-License-Identifier: MIT
#pragma once

#include <string_view>

namespace alidade {

/// True if the first image of a TIFF file cannot be decoded without an error. OpenCV ignores libtiff's
/// complaints about single strips and tiles. Damage that leaves valid codes is only detected if they have a
/// checksum (Deflate).
[[nodiscard]] bool isTiffDamaged(std::string_view content);

}  // namespace alidade
