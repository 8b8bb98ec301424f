// SPDX-License-Identifier: MIT
#pragma once

#include <string_view>

namespace alidade {

/// Whether the first image of a TIFF file cannot be decoded without an error. OpenCV ignores what libtiff
/// says of single strips and tiles. Damage within valid codes is only seen where they have a checksum
/// (Deflate).
[[nodiscard]] bool isTiffDamaged(std::string_view content);

}  // namespace alidade
