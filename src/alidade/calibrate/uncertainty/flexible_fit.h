// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "alidade/adjust/board/fit.h"

namespace alidade {

/// The same lens in a model of its kind with room for what the given one cannot express (see
/// ModelTraits::flexible_id), nothing held; nothing is solved again. Nothing where there is no such model.
/// @param fit  of one camera
[[nodiscard]] std::optional<Fit> flexibleFit(const Fit& fit);

}  // namespace alidade
