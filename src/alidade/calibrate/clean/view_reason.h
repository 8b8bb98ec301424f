// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "alidade/adjust/fit.h"
#include "alidade/core/cancel.h"
#include "alidade/target/view.h"

namespace alidade {

/// Why a view does not fit the camera of the others, as far as its corners show a reason.
/// @param used  the fit without the view
[[nodiscard]] std::string misfitReason(const Fit& used, const View& view, const CancelFlag* cancel);

}  // namespace alidade
