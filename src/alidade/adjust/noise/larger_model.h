// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>

#include "alidade/adjust/board/fit.h"
#include "alidade/adjust/noise/cross_validation.h"
#include "alidade/core/cancel.h"

namespace alidade {

/// The next larger model, if it explains the corners significantly better. It is solved from the final
/// solution of the fit, on the same corners and with the same loss, so that the costs are comparable.
[[nodiscard]] std::optional<BetterModel> betterModel(const Fit& fit, const CancelFlag* cancel);

/// The same, if the larger model also has the smaller cross-validation error, so that the
/// automatic choice would prefer it. If the cross-validation error of one is unknown, the fit
/// decides.
[[nodiscard]] std::optional<BetterModel> neededModel(const Fit& fit, const CancelFlag* cancel);

/// The relative reduction of the cost by a few steps of a model that contains the one in use. It shows
/// whether a larger model can help at all; in most cases it cannot.
[[nodiscard]] double dropAtAGlance(const Fit& fit, const std::string& larger_id, const CancelFlag* cancel);

}  // namespace alidade
