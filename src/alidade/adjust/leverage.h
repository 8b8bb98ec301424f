// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "alidade/adjust/fit.h"

namespace alidade {

/// Leverage of each corner: the trace, 0 to 2, of its block of the hat matrix of the weighted fit, with
/// intrinsics and all poses free. The squared error that the fit leaves of a corner is on average
/// (2 - leverage) times the variance of its coordinate; the sum over all corners is the number of free
/// parameters. A few precise corners among poor ones draw the fit towards them, and their small errors then
/// say little about their noise. 0 for a corner that does not project.
/// @param fit  of one camera
/// @returns a list a view
[[nodiscard]] std::vector<std::vector<double>> leverages(const Fit& fit);

}  // namespace alidade
