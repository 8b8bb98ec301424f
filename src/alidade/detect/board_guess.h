// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "alidade/core/cancel.h"
#include "alidade/imagery/image_set.h"

namespace alidade {

/// Which board some of the images show, and the flag to give, as one clause: "the images show a checkerboard
/// of 9x6 inner corners: --board checkerboard:9x6:SQUARE". Empty if they show none that is certain; images
/// that cannot be read are passed over. Of many images only some are searched.
/// @throws Cancelled
[[nodiscard]] std::string guessedBoard(const ImageSet& images, const CancelFlag* cancel = nullptr);

}  // namespace alidade
