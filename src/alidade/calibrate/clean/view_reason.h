// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "alidade/adjust/fit.h"
#include "alidade/calibrate/start/prepared_views.h"
#include "alidade/core/cancel.h"

namespace alidade {

/// The views that were set aside because they do not fit, each with its reason, as far as its corners show
/// one.
[[nodiscard]] std::vector<ExcludedView> misfitsOf(const Fit& fit, const PreparedViews& given,
                                                  const CancelFlag* cancel);

}  // namespace alidade
