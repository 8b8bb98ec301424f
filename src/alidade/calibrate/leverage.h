// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "alidade/calibrate/bundle_adjustment.h"

namespace alidade {

/// Leverage of each corner: the trace, 0 to 2, of its block of the hat matrix of the weighted fit, with
/// intrinsics and all poses free. The squared error that the fit leaves of a corner is on average
/// (2 - leverage) times the variance of its coordinate; the sum over all corners is the number of free
/// parameters. A few precise corners among poor ones draw the fit towards them, and their small errors then
/// say little about their noise. 0 for a corner that does not project.
[[nodiscard]] std::vector<std::vector<double>> leverages(std::string_view model_id,
                                                         std::span<const std::vector<Observation>> views,
                                                         const BundleState& state,
                                                         const ParamConstraint& constraint = {});

}  // namespace alidade
