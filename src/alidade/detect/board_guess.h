// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "alidade/core/cancel.h"
#include "alidade/imagery/image_set.h"

namespace alidade {

/// The board that some of the images show, and the flag to give, as one clause: "the images show a
/// checkerboard of 9x6 inner corners: --board checkerboard:9x6:SQUARE". Empty if no board is certain.
/// Unreadable images are skipped, and only some of many images are searched.
/// @throws Cancelled
[[nodiscard]] std::string guessedBoard(const ImageSet& images, const CancelFlag* cancel = nullptr);

}  // namespace alidade
