// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "alidade/adjust/board/fit.h"

namespace alidade {

/// The same lens in a more flexible model of the same kind (see ModelTraits::flexible_id), with nothing held
/// and nothing solved again. Nothing if there is no such model.
/// @param fit  of one camera
[[nodiscard]] std::optional<Fit> flexibleFit(const Fit& fit);

}  // namespace alidade
