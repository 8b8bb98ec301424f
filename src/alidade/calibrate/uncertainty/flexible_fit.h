// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string_view>

#include "alidade/adjust/board/fit.h"

namespace alidade {

/// Whether one or two numbers stand for the whole lens, which may then deviate from it even where boards were
/// seen, by too little to show in the errors.
[[nodiscard]] bool isStiff(std::string_view model_id);

/// The same lens in a model of its kind with room for what the given one cannot express, nothing held;
/// nothing is solved again. Nothing where there is no such model.
/// @param fit  of one camera
[[nodiscard]] std::optional<Fit> flexibleFit(const Fit& fit);

}  // namespace alidade
