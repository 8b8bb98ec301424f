// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>

namespace alidade {

/// Which board some of the images show, and the flag to give, as one clause: "the images show a checkerboard
/// of 9x6 inner corners: --board checkerboard:9x6:SQUARE". Empty if they show none that is certain; images
/// that cannot be read are passed over.
[[nodiscard]] std::string guessedBoard(std::span<const std::string> paths);

}  // namespace alidade
