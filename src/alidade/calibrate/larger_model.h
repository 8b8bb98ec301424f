// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "alidade/calibrate/estimation.h"

namespace alidade {

/// The next larger model, if it says beyond doubt that the one in use lacks something. It is solved from the
/// estimation's final answer, on the same corners and with the same loss, so that the two costs compare.
[[nodiscard]] std::optional<BetterModel> betterModel(const Estimation& estimation);

}  // namespace alidade
