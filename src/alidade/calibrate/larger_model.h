// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>

#include "alidade/calibrate/estimation.h"

namespace alidade {

/// The next larger model, if it explains the corners better beyond doubt. It is solved from the estimation's
/// final answer, on the same corners and with the same loss, so that the two costs compare.
[[nodiscard]] std::optional<BetterModel> betterModel(const Estimation& estimation);

/// The same, if it also predicts corners that it has not seen better: a model that chooseModel() would not
/// have chosen beside the larger one. Where the held-out errors of one are unknown, the fit decides.
[[nodiscard]] std::optional<BetterModel> neededModel(const Estimation& estimation);

/// By which share a few steps of a model that contains the one in use lower its cost. They tell whether there
/// is anything to gain; most often there is not.
[[nodiscard]] double dropAtAGlance(const Estimation& estimation, const std::string& larger_id);

}  // namespace alidade
